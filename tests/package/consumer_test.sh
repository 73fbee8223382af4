#!/usr/bin/env bash
# consumer_test.sh BUILD SCRATCH COMPILER: installs BUILD into SCRATCH; builds the participant of examples/01-participant
# there, once by find_package and once by pkg-config; couples the two through the installed `sluice run`.
# Nothing of the build or of the sources' headers may be needed.
set -euo pipefail
build=$1 scratch=$2 compiler=$3
here=$(cd "$(dirname "$0")" && pwd)
example=$(cd "$here/../../examples/01-participant" && pwd)
prefix=$scratch/prefix
rm -rf "$scratch"
mkdir -p "$scratch/path"

DESTDIR='' cmake --install "$build" --prefix "$prefix" >"$scratch/install.log"
for file in bin/sluice bin/dem bin/lbm share/sluice/report/report.py share/sluice/configs/immersed_column.yaml; do
    [ -e "$prefix/$file" ] || { echo "not installed: $file" && exit 1; }
done

cmake -S "$here/consumer" -B "$scratch/cmake" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler" \
    -DSOURCE="$example/spring.cpp" >"$scratch/configure.log"
cmake --build "$scratch/cmake"
cp "$scratch/cmake/by_cmake" "$scratch/path/"

PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name sluice.pc)")
export PKG_CONFIG_PATH
[ "$(pkg-config --modversion sluice)" = "$("$prefix/bin/sluice" --version)" ]
# shellcheck disable=SC2046
"$compiler" -std=c++20 "$example/spring.cpp" -o "$scratch/path/by_pkg_config" $(pkg-config --cflags --libs sluice) \
    -Wl,-rpath,"$(pkg-config --variable=libdir sluice)"

cd "$scratch"  # away from the sources
PATH=$scratch/path:$PATH "$prefix/bin/sluice" run "$example/spring.yaml" --out run --no-report \
    --set participants.left.solver=by_cmake --set participants.right.solver=by_pkg_config
python3 - run/summary.json <<'END'
import json, sys
summary = json.load(open(sys.argv[1]))
assert summary["exit"] == 0 and summary["windows"] == 200, summary  # 1 s in windows of 5 ms
END
# The library in use is the installed one; what it links itself is no affair of its user's.
for program in by_cmake by_pkg_config; do
    libraries=$(ldd "path/$program") needed=$(readelf -d "path/$program" | grep NEEDED)
    grep -q "=> $prefix/lib.*/libsluice.so" <<<"$libraries" || { echo "$libraries" && exit 1; }
    ! grep -E 'zmq|hdf5|libmpi|fmt' <<<"$needed" || exit 1
done
echo "installed, built twice, coupled"
