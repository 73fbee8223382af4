#!/usr/bin/env bash
# remote_hosts_test.sh ssh|srun CASE SLUICE TOY [CONFIGS]: runs that `sluice run` on host a starts, a participant on each
# of two hosts.
set -euo pipefail
by=$1 case=$2 sluice=$3 toy=$4 configs=${5:-}
here=$(dirname "$0")
# shellcheck source=tests/support/two_hosts.sh
. "$here/../support/two_hosts.sh"
case $by in
    ssh) . "$here/../support/ssh_host.sh" ;;
    srun) . "$here/../support/slurm_hosts.sh" ;;
esac
nap="" keep=true more="" right_more=""

# network: what a scene says about hosts, keys and how to get there
network() { printf 'port: 5000\nsecurity: {keys: %s}\nremote: [%s]\n' "$work/keys" "$reach"; }

# scene NAME LEFT RIGHT: two coupled masses, with more keys for each participant
scene() {
    cat >"$work/$1.yaml" <<EOT
sluice: 1
time: {end: 0.5, window: 0.001}
data: {place: {meshless: true, columns: {place: {unit: m}}}}
$more
participants:
  left: {command: $toy, $2 config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 1, keep: $keep${nap:+, nap: $nap}}}
  right: {command: $toy, $3 config: {mass: 1, wall_spring: 39, middle_spring: 158, place: 0, keep: $keep}}
couplings:
  - {from: left, to: right, data: place}
  - {from: right, to: left, data: place, lag: 1, predict: linear}
EOT
}

hosts() { # hosts [KEYS]: the scene `two`
    scene names "" "" && "$sluice" keygen "$work/keys" "$work/names.yaml" >"$work/keygen.log"
    more="$(network)${1:+
$1}"
    scene two "host: host-a," "host: ${right_host:-host-b}, $right_more"
}

# launch CODE: `sluice run` of the scene `two`, to its end
launch() {
    local code=0
    on_a timeout 60 "$sluice" run "$work/two.yaml" --out "$work/two" --no-report --quiet >"$work/two.log" 2>&1 || code=$?
    [ "$code" = "$1" ] || fail "sluice run ended with exit $code (expected $1)"
}

background() { # a run that goes on; $run
    on_a "$sluice" run "$work/two.yaml" --out "$work/two" --no-report --quiet >"$work/two.log" 2>&1 &
    run=$!
}

# underway NAME: until that participant's status page tells of a window
underway() {
    local tries window
    for tries in $(seq 300); do
        window=$(od -An -t d8 -j 8 -N 8 "$work/two/.sluice/$1.status" 2>/dev/null || true)
        [ "${window:-0}" -gt 3 ] && return
        sleep 0.1
    done
    fail "\"$1\" does not get to its windows"
}

says() { grep -qF -- "$1" "$work/two.log" || fail "it does not say: $1"; }
says_once() { # one message, the first line of the output, and no second one beside it
    says "$1"
    head -n 1 "$work/two.log" | grep -qF -- "$1" || fail "that is not what it says first: $1"
    [ "$(grep -c '^[^ ]' "$work/two.log")" = 1 ] || fail "more than one message"
}

case $case in
    bits) # the bits of one host
        scene one "" ""
        on_a "$sluice" run "$work/one.yaml" --out "$work/one" --no-report --quiet >"$work/one.log" 2>&1 || fail "one host"
        hosts
        cd "$work"
        launch 0
        for name in left right; do
            expected=$(grep '"final place' "$work/one/.sluice/$name.json") || fail "no result of $name on one host"
            [ "$expected" = "$(grep '"final place' "$work/two/.sluice/$name.json")" ] || fail "$name: other bits"
            grep -q '"transport": "zmq"' "$work/two/.sluice/$name.json" || fail "$name did not use the network"
        done
        ;;
    solvers) # our own solvers: the files of one host, byte for byte
        small="time.end=0.004 participants.grains.config.column.count=60 participants.water.config.cell=2.0e-4
               participants.water.config.domain.size=[0.04,0.02] output.interval=0.001"
        settings=()
        for setting in $small; do settings+=(--set "$setting"); done
        cp "$configs/immersed_column.yaml" "$work/column.yaml"
        export SLUICE_CACHE=$work/cache
        on_a "$sluice" run "$work/column.yaml" --out "$work/one" --no-report --quiet "${settings[@]}" \
            >"$work/one.log" 2>&1 || fail "one host"
        "$sluice" keygen "$work/keys" "$work/column.yaml" >"$work/keygen.log"
        network >>"$work/column.yaml"
        settings+=(--set participants.grains.host=host-a --set participants.water.host=host-b)
        on_a "$sluice" run "$work/column.yaml" --out "$work/two" --no-report --quiet "${settings[@]}" \
            >"$work/two.log" 2>&1 || fail "two hosts"
        [ "$(wc -l <"$work/one/series.csv")" -gt 2 ] || fail "no series on one host"
        for file in series.csv grains.csv water.csv; do
            cmp "$work/one/$file" "$work/two/$file" || fail "$file: other bytes"
        done
        for file in "$work"/one/grains/* "$work"/one/water/*; do
            cmp "$file" "${file/one/two}" || fail "$file: other bytes"
        done
        grep -q '"transport": "zmq"' "$work/two/.sluice/water.json" || fail "they did not use the network"
        ;;
    ranks) # two processes of the participant on the other host: the bits of one host, and nothing left if it is killed
        right_more="ranks: 2, "
        scene one "" "$right_more"
        on_a "$sluice" run "$work/one.yaml" --out "$work/one" --no-report --quiet >"$work/one.log" 2>&1 || fail "one host"
        hosts
        launch 0
        expected=$(grep '"final place' "$work/one/.sluice/left.json") || fail "no result on one host"
        [ "$expected" = "$(grep '"final place' "$work/two/.sluice/left.json")" ] || fail "other bits"
        nobody_left
        sed -i "s/place: 1,/place: 1, nap: 0.02,/" "$work/two.yaml"
        background
        underway right:1
        on_a pkill -KILL -f "^$sluice run"
        expect 137 "$run" "sluice run"
        ;;
    dies) # kill -9 of the participant on the other host
        nap=0.02
        hosts
        background
        underway right
        on_b pkill -KILL -f -- "--as right" || fail "nothing to kill"
        expect 3 "$run" "sluice run"
        says_once 'participant "right" on host-b '
        ;;
    restarted) # the same with on-death: restart: it is started again there, and the end has the bits of one host
        nap=0.005
        scene one "" ""
        on_a "$sluice" run "$work/one.yaml" --out "$work/one" --no-report --quiet >"$work/one.log" 2>&1 || fail "one host"
        hosts "on-death: restart
checkpoint: {windows: 20}"
        background
        for _ in $(seq 300); do ls "$work"/two/checkpoints/*/manifest.json >/dev/null 2>&1 && break || sleep 0.05; done
        on_b pkill -KILL -f -- "--as right" || fail "nothing to kill"
        expect 0 "$run" "sluice run"
        says 'participant "right" on host-b '
        says "started again, all go on from window "
        for name in left right; do
            expected=$(grep '"final place' "$work/one/.sluice/$name.json") || fail "no result of $name on one host"
            [ "$expected" = "$(grep '"final place' "$work/two/.sluice/$name.json")" ] || fail "$name: other bits"
        done
        ;;
    here_dies) # and of the one on this host
        nap=0.02
        hosts
        background
        underway right
        on_a pkill -KILL -f -- "^$toy .*--as left"
        expect 3 "$run" "sluice run"
        says_once 'participant "left" was ended by signal 9'
        ;;
    interrupted) # Ctrl-C: all end before their next window, with a checkpoint
        nap=0.02
        hosts
        background
        underway right
        on_a pkill -INT -f "^$sluice run"
        expect 75 "$run" "sluice run"
        says_once "stopped by Interrupt before window "
        on_a "$sluice" resume "$work/two" --no-report --quiet --set participants.left.config.nap=0 >"$work/resume.log" 2>&1 ||
            fail "it cannot be resumed"
        ;;
    twice) # Ctrl-C twice while one participant hangs on the other host
        nap=0.02
        hosts
        sed -i "s/place: 0,/place: 0, fault: hang, fault_window: 10,/" "$work/two.yaml"
        background
        underway right
        sleep 1
        on_a pkill -INT -f "^$sluice run"
        sleep 0.3
        on_a pkill -INT -f "^$sluice run"
        expect 130 "$run" "sluice run"
        says_once "stopped by Interrupt: "
        ;;
    killed) # kill -9 of the launcher
        nap=0.02
        hosts
        background
        underway right
        on_a pkill -KILL -f "^$sluice run"
        expect 137 "$run" "sluice run"
        ;;
    partition) # the network between the hosts is gone
        nap=0.02
        hosts "timeouts: {silence: 2}"
        background
        underway right
        partition
        expect 3 "$run" "sluice run"
        says "no heartbeat for 2 s"
        ;;
    down) # nobody has the other host's address; with Slurm: no node has that name
        right_host=10.71.0.9
        hosts
        launch 7
        says_once ": the run cannot be started on other hosts"
        says '  10.71.0.9, for participant "right":'
        says "cannot be reached by \`$reach_tool"
        ;;
    silent) # the other host does not answer
        hosts "timeouts: {connect: 3}"
        partition
        launch 7
        says_once ": the run cannot be started on other hosts"
        says "host-b\`: it does not answer"
        ;;
    absent) # neither the program nor the run's directory is there; said before anything is started
        mkdir "$work/bin" && cp "$toy" "$work/bin/toy" && toy=$work/bin/toy
        hosts
        mkdir "$work/two"
        for folder in bin two; do on_b mount -t tmpfs none "$work/$folder"; done
        launch 7
        says_once ": the run cannot be started on other hosts"
        says "    no $work/bin/toy: the program"
        says "    no $work/two with what is in it here: the directory of the run"
        code=0
        on_a "$sluice" check "$work/two.yaml" >"$work/two.log" 2>&1 || code=$?
        [ "$code" = 7 ] || fail "sluice check ended with exit $code (expected 7)"
        says "    no $work/bin/toy: the program"
        ;;
    *) echo "no case $case" && exit 2 ;;
esac
nobody_left
if grep -qF -f <(cat "$work"/keys/*.secret) -r --include='*.log' "$work"; then fail "a secret was printed"; fi
echo "$by $case: ok"
