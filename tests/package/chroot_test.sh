#!/usr/bin/env bash
# chroot_test.sh DEB: the package in a clean, minimal Debian of this machine's release: it installs with what it depends
# on, runs a shortened immersed column with each instruction set that the processor has (without a report: that takes
# recommended packages), then once more with report and picture of the scene, and goes without a trace.
# Needs root, debootstrap and a package mirror, which is whatever apt is configured with. Exit code 77: not possible here.
# All mounts and processes live in namespaces that end with this script; the folder is removed.
set -euo pipefail

outside() {
    local deb root
    deb=$(realpath "$1")
    [ "$(id -u)" = 0 ] || { echo "chroot_test: needs root." && exit 77; }
    command -v debootstrap >/dev/null || { echo "chroot_test: needs the package debootstrap." && exit 77; }
    root=$(mktemp -d /tmp/sluice-chroot-XXXXXX)
    # shellcheck disable=SC2064
    trap "rm -rf --one-file-system '$root'" EXIT
    unshare --mount --pid --fork --kill-child bash "$0" --inside "$deb" "$root"
}

# make_debian ROOT: minimal, with this machine's package sources.
make_debian() {
    local root=$1 mirror codename
    # shellcheck disable=SC1091
    codename=$(. /etc/os-release && echo "$VERSION_CODENAME")
    mirror=$(apt-get indextargets --format '$(CODENAME) $(REPO_URI)' 'Created-By: Packages' |
        awk -v name="$codename" '$1 == name && !found++ { print $2 }')
    [ -n "$mirror" ] || { echo "chroot_test: apt has no source for $codename." && exit 77; }
    debootstrap --variant=minbase "$codename" "$root" "$mirror" >"$root.log" 2>&1 || { tail "$root.log" && exit 1; }
    rm "$root.log"
    chmod 755 "$root"  # apt downloads as a user of its own
    rm -r "$root/etc/apt"
    cp -a /etc/apt "$root/etc/"
    cp -an /usr/share/keyrings/. "$root/usr/share/keyrings/"
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    mount -t proc proc "$root/proc"
    mkdir -p "$root/dev/shm"
    mount -t tmpfs tmpfs "$root/dev/shm" -o mode=1777
}

as_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive LC_ALL=C "$@"; }
as_user() { chroot --userspec=1000:1000 "$root" env -i -C /home/user PATH=/usr/bin:/bin HOME=/home/user LC_ALL=C "$@"; }

# install WHAT PACKAGE...: with what they depend on, and how long that took.
install() {
    local what=$1 begin
    shift
    begin=$(date +%s)
    as_root apt-get install -y -qq --no-install-recommends "$@" >"$root/tmp/install.log" 2>&1 ||
        { tail "$root/tmp/install.log" && exit 1; }
    echo "$what: installed $(grep -c '^Setting up' "$root/tmp/install.log") packages in $(($(date +%s) - begin)) s"
}

# column OUT [NAME=VALUE]: sixty grains in a small tank, a second of computing; NAME=VALUE in the environment.
column() {
    local out=$1
    shift
    as_user "$@" sluice run /usr/share/sluice/configs/immersed_column.yaml --out "$out" --set time.end=0.004 \
        --set participants.grains.config.column.count=60 --set participants.water.config.cell=2.0e-4 \
        --set "participants.water.config.domain.size=[0.04, 0.02]" --set output.interval=0.001
}

# run_level LEVEL: the column by it, and a look at which files the two solvers run from meanwhile.
run_level() {
    local level=$1 files="" run
    column "$level" "SLUICE_ISA=$level" >"$root.$level" 2>&1 &
    run=$!
    while kill -0 $run 2>/dev/null; do
        files="$files $(readlink /proc/[0-9]*/exe 2>/dev/null | grep -E '/lib/sluice/' || true)"
        sleep 0.05
    done
    wait $run || { cat "$root.$level" && exit 1; }
    rm "$root.$level"
    local solver
    for solver in dem lbm mpm; do
        grep -q "/usr/lib/sluice/$level/$solver" <<<"$files" || { echo "$solver did not run as $level:$files" && exit 1; }
    done
    ! grep -oE '/lib/sluice/[^/ ]+' <<<"$files" | grep -vx "/lib/sluice/$level" || exit 1
    echo "ran as $level"
}

# check_code FOLDER: the solvers in it are compiled for what their folders are called: ymm is AVX2's, zmm AVX-512's.
check_code() {
    local level solver ymm zmm
    for level in x86-64 x86-64-v3 x86-64-v4; do
        for solver in dem lbm mpm; do
            ymm=$(objdump -d "$1/$level/$solver" | grep -c '%ymm' || true)
            zmm=$(objdump -d "$1/$level/$solver" | grep -c '%zmm' || true)
            case $level:$((ymm > 0)):$((zmm > 0)) in
                x86-64:0:0 | x86-64-v3:1:0 | x86-64-v4:1:1) ;;
                *) echo "$level/$solver has $ymm instructions on ymm and $zmm on zmm registers" && exit 1 ;;
            esac
        done
    done
}

inside() {
    local deb=$1 level
    root=$2
    mount -t proc proc /proc  # of this namespace, for run_level
    make_debian "$root"
    cp "$deb" "$root/tmp/sluice.deb"
    as_root dpkg-deb --field /tmp/sluice.deb Depends | sed 's/^/Depends: /'
    as_root apt-get update -qq
    install "sluice and what it depends on" /tmp/sluice.deb
    check_code "$root/usr/lib/sluice"
    as_root useradd --create-home --uid 1000 user
    as_user sluice --version
    if as_user sluice doctor --help >/dev/null 2>&1; then as_user sluice doctor; fi
    local loader
    loader=$(as_root /lib64/ld-linux-x86-64.so.2 --help)  # glibc's opinion of the processor
    for level in x86-64 x86-64-v3 x86-64-v4; do
        if [ $level = x86-64 ] || grep -q "$level (supported" <<<"$loader"; then
            run_level $level
        else
            local code=0
            as_user "SLUICE_ISA=$level" lbm --help || code=$?
            [ $code = 2 ] || { echo "$level is not here, but lbm ended with $code" && exit 1; }
        fi
    done
    # shellcheck disable=SC2046
    install "what it recommends" $(dpkg-deb --field "$deb" Recommends | tr -d ,)
    column free
    [ -s "$root/home/user/free/report.html" ] || { echo "no report" && exit 1; }
    as_user sluice graph /usr/share/sluice/configs/immersed_column.yaml -o graph.svg
    [ -s "$root/home/user/graph.svg" ] || { echo "no picture" && exit 1; }
    as_root apt-get purge -y -qq sluice >/dev/null 2>&1
    local left
    left=$(find "$root/usr" -iname '*sluice*' && find "$root/usr/bin" -name dem -o -name lbm -o -name mpm)
    [ -z "$left" ] || { echo "left behind after removal: $left" && exit 1; }
    echo "removed without a trace"
}

case "${1:-}" in
    --inside) inside "$2" "$3" ;;
    *.deb) outside "$1" ;;
    *) echo "chroot_test.sh PACKAGE.deb" >&2 && exit 2 ;;
esac
