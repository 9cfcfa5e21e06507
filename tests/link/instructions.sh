#!/usr/bin/env bash
# Counts instructions per frustum in frames that an installed library draws: counts, unlike seconds, do not depend on
# the machine.
#
#   instructions.sh SOURCES PREFIX
#
# SOURCES is the source tree, PREFIX where the library is. Writes to the current directory.
set -euo pipefail
sources=$1 prefix=$2
unset LD_LIBRARY_PATH
cc -std=c99 -O2 "$sources/tests/link/frusta.c" "$sources/tests/c/check.c" -o frusta \
    -I"$prefix/include" -L"$prefix/lib" -licoray -lm -Wl,-rpath,"$prefix/lib"

# Instructions per frustum read that were reached on the instruction set that valgrind has (AVX2), by transfer function,
# light and heights. A lit frame over native heights includes gradients and normals.
reached='span unlit mean 247
dense unlit mean 334
thin unlit mean 1242
dense lit mean 760
thin lit mean 1773
dense unlit native 479
dense lit native 1160'
# Largest difference from these, percent. If frames need fewer, write them down above.
tolerance=10

# count FRAME...: prints the instructions of a run, and its frusta.
count() {
    local printed counted frusta
    printed=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null ./frusta "$@" 2>&1) ||
        { echo "$printed" >&2; return 1; }
    counted=$(awk '/Collected/ { print $NF }' <<<"$printed") frusta=$(awk '/^frusta / { print $2 }' <<<"$printed")
    [ -n "$counted" ] && [ -n "$frusta" ] || { echo "$printed" >&2; return 1; }
    echo "$counted $frusta"
}

counts=$(count span unlit mean 0)
without=${counts% *}
failed=0
while read -r transfer light heights expected; do
    counts=$(count "$transfer" "$light" "$heights" 1)
    found=$(((${counts% *} - without) / ${counts#* }))
    echo "$transfer, $light, $heights heights: $found instructions per frustum"
    difference=$((100 * (found - expected)))
    if [ $((difference < 0 ? -difference : difference)) -gt $((tolerance * expected)) ]; then
        echo "$transfer, $light, $heights heights: $found instructions per frustum, expected $expected" >&2
        failed=1
    fi
done <<<"$reached"
exit $failed
