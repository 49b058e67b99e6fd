#!/bin/bash
# All checks: set-up, format, warnings as errors, tests, sanitizers on the readers, the shipped cases, the main job at
# reduced size, the commands in the documentation, and fuzzers of everything that reads, five seconds each. Ends with a
# summary; exit status 0 only if everything passed.
# test.sh [--slurm] [--long] [--fuzz]: also on a real Slurm of one node (needs scripts/setup.sh slurm); with fifty kills of
# each kind; with a minute for each fuzzer.
# Environment: STRAKE_DATA, a folder of surfaces from outside; tests that need it skip without it.
set -uo pipefail
cd "$(dirname "$0")"
export CLICOLOR=0
fuzz_seconds=5
for option in "$@"; do
    case $option in
    --slurm) export STRAKE_SLURM=1 ;;
    --long) export STRAKE_LONG=1 ;;
    --fuzz) fuzz_seconds=60 ;;
    *) echo "usage: test.sh [--slurm] [--long] [--fuzz]" >&2; exit 2 ;;
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
    fi
}
finish() {
    printf '\n'
    printf '%s\n' "${summary[@]}"
    printf '%d passed, %d failed\n' $passed $failed
    [ $failed = 0 ]
    exit
}

sources() { find cases cli core objectives optimize python report tests bench \( -name '*.cpp' -o -name '*.hpp' \) -print0; }
format() { sources | xargs -0 clang-format --dry-run -Werror; }
# What ccache keeps serves every checkout; without it headers are precompiled.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=true
configure() {  # PRESET
    local -a quick=(-DSTRAKE_PRECOMPILE=ON) python=()
    ! command -v ccache >/dev/null || quick=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    [ "$1" != release ] || [ ! -e /usr/include/pybind11/pybind11.h ] || python=(-DSTRAKE_PYTHON=ON)
    cmake --preset "$1" "${quick[@]}" "${python[@]}"
}
release_build() { configure release && cmake --build --preset release; }
# The programs that read what others wrote, under ASan and UBSan: all tests of the readers and of the case loader.
sanitized() {
    local -a tests
    mapfile -t tests < <(find tests/core/mesh/{io*,npy,vtp_reader}_test.cpp tests/cases/*_test.cpp -printf '%f\n' | sed 's/\.cpp$//')
    configure sanitize && cmake --build --preset sanitize --target "${tests[@]}" || return 1
    local pattern
    pattern=$(IFS='|'; echo "${tests[*]}")
    ctest --test-dir build/sanitize --output-on-failure --no-tests=error -j2 -R "^($pattern)\$"
}
unit_tests() { ctest --preset release -j2; }
check_cases() {
    scripts/examples.sh cases "$bin" || return 1
    local file count=0 bad=0
    while IFS= read -r -d '' file; do
        grep -q '^case *:' "$file" || continue
        [ "$file" != cases/paper/bunny.yaml ] || [ -e cases/paper/generated/bunny.ply ] || continue  # a download
        count=$((count + 1))
        "$bin/strake" check "$file" || { echo "$file: status $?"; bad=$((bad + 1)); }
    done < <(find cases -name '*.yaml' -not -path '*/generated/*' -print0 | sort -z)
    echo "$count cases checked"
    [ $count -gt 0 ] && [ $bad = 0 ]
}
main_job() { scripts/main_job.sh "$bin" 6000; }
fuzzers() { scripts/fuzz.sh $fuzz_seconds; }
snippets() { scripts/check_snippets.py "$bin"; }

step "set-up" scripts/setup.sh run test ${STRAKE_SLURM:+slurm}
[ $failed = 0 ] || finish
step "format" format
step "release build" release_build
[ $failed = 0 ] || finish
bin=$PWD/build/test-bin
mkdir -p "$bin"
ln -sfn ../release/cli/strake ../release/cases/geometry/make_surface ../release/python "$bin"
step "tests" unit_tests
step "cases" check_cases
step "main job" main_job
step "snippets" snippets
step "sanitizers" sanitized
step "fuzzers" fuzzers
finish
