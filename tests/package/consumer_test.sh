#!/usr/bin/env bash
# consumer_test.sh BUILD SCRATCH COMPILER: installs BUILD into SCRATCH; builds the participant of examples/01-participant
# there, once by find_package and once by pkg-config; couples the two through the installed `sluice run`; then one in C,
# built by pkg-config, with one in Python.
# Nothing of the build or of the sources' headers may be needed.
set -euo pipefail
build=$1 scratch=$2 compiler=$3
here=$(cd "$(dirname "$0")" && pwd)
example=$(cd "$here/../../examples/01-participant" && pwd)
prefix=$scratch/prefix
rm -rf "$scratch"
mkdir -p "$scratch/path"

DESTDIR='' cmake --install "$build" --prefix "$prefix" >"$scratch/install.log"
for file in bin/sluice bin/dem bin/lbm bin/mpm share/sluice/report/report.py share/sluice/configs/immersed_column.yaml; do
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

# C and Python, from the same place; the results are those of C++.
# shellcheck disable=SC2046
cc -std=c99 "$example/../02-participant-c/spring.c" -o "$scratch/path/in_c" $(pkg-config --cflags --libs sluice_c) \
    -Wl,-rpath,"$(pkg-config --variable=libdir sluice_c)"
! readelf -d path/in_c | grep NEEDED | grep -E 'yaml|stdc\+\+|libsluice\.so' || exit 1
sed "s#right: {solver: example_spring#right: {command: [/usr/bin/python3, $example/../03-participant-python/spring.py]#" \
    "$example/spring.yaml" >mixed.yaml
PATH=$scratch/path:$PATH PYTHONPATH=$prefix/lib/python3/dist-packages "$prefix/bin/sluice" run mixed.yaml --out mixed \
    --no-report --set participants.left.solver=in_c
python3 - run mixed <<'END'
import json, sys
places = [[json.load(open(f"{run}/.sluice/{name}.json"))["facts"]["place at the end [m]"] for name in ("left", "right")]
          for run in sys.argv[1:]]
assert places[0] == places[1], places
END
echo "installed, built twice, coupled; in C and Python too"
