#!/bin/bash
# The checks that every change must pass: set-up, format, warnings as errors, tests, shipped cases, the main job at reduced
# size, the commands of the documentation, sanitizers on what reads from outside, and fuzzers of it, five seconds each. Ends
# with a summary; exit status 0 only if everything passed. Under 15 minutes on two cores from a clean clone.
# test.sh [--all] [--slurm] [--long] [--fuzz] [--parcel] [--published]: --all also everything else: each source compiled by itself, sanitizers on
# everything, clang-tidy, and the three that follow; --slurm: on a real Slurm of one node (needs scripts/setup.sh slurm);
# --long: with fifty kills of each kind; --fuzz: with a minute for each fuzzer; --parcel: only licences, spelling,
# the API's reference and the Debian packages, ten minutes (scripts/check_parcel.sh); --published: only all problems with published
# answers at their full size, with OpenFOAM (scripts/published.sh). It fails where a number is missed and docs/published.md does not say why.
# Environment: STRAKE_DATA, a folder of surfaces from outside; tests that need it skip without it.
set -uo pipefail
cd "$(dirname "$0")"
export CLICOLOR=0
# Debian's programs first: a version manager's python3 in front of them starts ten times slower, and tests start it often.
export PATH=/usr/bin:$PATH
fuzz_seconds=5 all= parcel= published=
for option in "$@"; do
    case $option in
    --all) all=yes fuzz_seconds=60; export STRAKE_LONG=1; ! command -v sbatch >/dev/null || export STRAKE_SLURM=1 ;;
    --slurm) export STRAKE_SLURM=1 ;;
    --long) export STRAKE_LONG=1 ;;
    --fuzz) fuzz_seconds=60 ;;
    --parcel) parcel=yes ;;
    --published) published=yes ;;
    *) echo "usage: test.sh [--all] [--slurm] [--long] [--fuzz] [--parcel] [--published]" >&2; exit 2 ;;
    esac
done
logs=build/test-logs
mkdir -p $logs
passed=0 failed=0 summary=()

# step NAME COMMAND...: runs it, keeps its output in a log, shows the end of it after a failure.
step() {
    local name=$1 log=$logs/${1// /-}.log begin=$SECONDS
    shift
    printf '== %s\n' "$name"
    if "$@" >"$log" 2>&1; then
        passed=$((passed + 1))
        summary+=("$(printf 'passed  %4d s  %s' $((SECONDS - begin)) "$name")")
        grep -E '^(100%|[0-9]+% tests passed|Total Test time)' "$log" || true
    else
        failed=$((failed + 1))
        summary+=("$(printf 'FAILED  %4d s  %s (%s)' $((SECONDS - begin)) "$name" "$log")")
        tail -n 60 "$log"
        # What failed in which test stands far above the end.
        grep -nE -A 8 ': Failure$|^(Traceback|AssertionError)|ERROR: |FAIL: ' "$log" | tail -n 60
    fi
}
finish() {
    printf '\n'
    printf '%s\n' "${summary[@]}"
    local log=build/release/Testing/Temporary/LastTest.log
    [ ! -e $log ] || scripts/skipped.py $log
    printf '%d passed, %d failed, %d s\n' $passed $failed $SECONDS
    [ $failed = 0 ]
    exit
}

sources() { find bench casefile cases cli core objectives optimize python report studio tests viewer \( -name '*.cpp' -o -name '*.hpp' \) -print0; }
format() { sources | xargs -0 clang-format --dry-run -Werror; }
# What ccache keeps serves every checkout.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=true
configure() {  # PRESET OPTIONS...
    local -a quick=()
    ! command -v ccache >/dev/null || quick=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    cmake --preset "$1" "${quick[@]}" "${@:2}"
}
release_build() {
    local python=OFF
    [ ! -e /usr/include/pybind11/pybind11.h ] || python=ON
    configure release -DSTRAKE_UNITY=ON -DSTRAKE_PYTHON=$python && cmake --build --preset release
}
tests() { ctest --preset release -j2; }
# The programs that read what others wrote, under ASan and UBSan: all tests of the readers and of the case loader.
sanitized() {
    local from=$PWD/build/release
    [ -z "$all" ] || from=
    configure sanitize -DSTRAKE_SOLVERS_FROM="$from" || return 1
    if [ -n "$all" ]; then
        cmake --build --preset sanitize && ctest --test-dir build/sanitize --output-on-failure -j2
    else
        cmake --build --preset sanitize --target formats_tests casefile_tests fuzz_bytes fuzz_case fuzz_seeds &&
            printf '%s\n' build/sanitize/tests/core/formats/formats_tests GTEST_SHARD_INDEX={0,1}" GTEST_TOTAL_SHARDS=2 build/sanitize/tests/casefile/casefile_tests" |
            xargs -P 2 -I{} sh -c {}
    fi
}
fuzzers() { scripts/fuzz.sh $fuzz_seconds; }
# Each source by itself, without precompiled headers: a missing include is found. Then clang-tidy by the same build.
each_by_itself() {
    cmake --preset release -B build/alone -DSTRAKE_PRECOMPILE=OFF -DSTRAKE_UNITY=OFF -DCMAKE_EXPORT_COMPILE_COMMANDS=ON &&
        ninja -C build/alone
}
functions() { scripts/check_functions.py --clang-tidy build/alone; }

if [ -n "$parcel" ]; then
    step "set-up" scripts/setup.sh run package
    [ $failed = 0 ] && step "parcel" scripts/check_parcel.sh
    finish
fi
if [ -n "$published" ]; then
    step "set-up" scripts/setup.sh run test openfoam
    [ $failed = 0 ] && step "release build" release_build
    [ $failed = 0 ] && step "published" scripts/published.sh
    finish
fi
step "set-up" scripts/setup.sh run test ${STRAKE_SLURM:+slurm}
[ $failed = 0 ] || finish
step "format" format
step "release build" release_build
[ $failed = 0 ] || finish
step "tests" tests
step "sanitizers" sanitized
step "fuzzers" fuzzers
if [ -n "$all" ]; then
    step "each source by itself" each_by_itself
    step "clang-tidy" functions
fi
finish
