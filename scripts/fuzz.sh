#!/bin/bash
# Fuzzes every reader, repair, the loader of cases and the studio's requests with libFuzzer under ASan and UBSan: fuzz.sh [SECONDS_EACH [NAME...]]
# What is found lies in build/sanitize/findings and makes the exit status 1; a finding is run again by
#   FUZZ=NAME build/sanitize/tests/fuzz/fuzz_bytes FILE        (fuzz_case FILE for cases, fuzz_studio FILE)
set -uo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-5}
names=(stl obj ply off tri su2 msh nas vtk vtp vtp_fields gz npy su2_volume vtu foam repair case studio)
[ $# -le 1 ] || names=("${@:2}")
build=build/sanitize
[ -e $build/build.ninja ] || cmake --preset sanitize || exit 1
cmake --build --preset sanitize --target fuzz_bytes fuzz_case fuzz_studio fuzz_seeds >/dev/null || exit 1
rm -rf $build/findings $build/seeds
mkdir -p $build/findings $build/corpus $build/logs
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=0 UBSAN_OPTIONS=print_stacktrace=1
$build/tests/fuzz/fuzz_seeds $build/seeds tests/casefile/case_fuzz_test.cpp || exit 1

# one NAME: what the seeds and earlier runs found is the corpus; a fixed seed makes short runs alike.
one() {
    local program=$build/tests/fuzz/fuzz_bytes length=4096
    [ "$1" != studio ] || program=$build/tests/fuzz/fuzz_studio
    [ "$1" != case ] || program=$build/tests/fuzz/fuzz_case length=3000
    mkdir -p "$build/corpus/$1"
    if FUZZ=$1 $program -max_total_time="$seconds" -max_len=$length -timeout=10 -rss_limit_mb=2048 -seed=1 -verbosity=1 \
        -print_final_stats=1 -artifact_prefix="$build/findings/$1-" "$build/corpus/$1" "$build/seeds/$1" \
        >"$build/logs/$1.log" 2>&1; then
        printf '%-11s %s\n' "$1" "$(awk -F: '/number_of_executed_units/ {runs = $4 + 0} /cov:/ {split($0, c, "cov: "); split(c[2], n, " ")} END {print runs " runs, " n[1] " edges"}' "$build/logs/$1.log")"
    else
        printf '%-11s FOUND something, see %s\n' "$1" "$build/logs/$1.log"
        tail -n 40 "$build/logs/$1.log"
        return 1
    fi
}
export -f one
export build seconds
printf '%s\n' "${names[@]}" | xargs -P 2 -I{} bash -c 'one {}'
[ "$(ls -A $build/findings)" = "" ]
