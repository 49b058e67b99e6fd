#!/bin/bash
# scripts/progress.sh, which shows what run.sh and setup.sh do: progress_test.sh SCRIPT
# A command's own words, its exit status, and warnings of CMake with what they say.
set -u
. "$1"
failures=0
expect() {  # WANTED_STATUS STATUS WORDS: what `seen` holds
    case $seen in
    *"$3"*) [ "$1" = "$2" ] && return ;;
    esac
    printf 'expected status %s and "%s", got %s and:\n%s\n' "$1" "$3" "$2" "$seen" >&2
    failures=$((failures + 1))
}
ends() { printf 'status       converged\n[1/2] one\n'; return "$1"; }
seen=$(progress Title 3 ends 0 2>&1); expect 0 $? 'Title: done in'
seen=$(progress Title 3 ends 3 2>&1); expect 3 $? 'Title: failed, status 3'
expect 3 3 'status       converged'
warns() { printf 'CMake Warning at a.cmake:20 (message):\n  The page\n  is missing\n\n\n-- Done\nx.cpp:1: warning: unused\n'; }
seen=$(progress Title 3 warns 2>&1); expect 0 $? $'(message):\n  The page\n  is missing\nx.cpp:1: warning: unused'
[ $failures = 0 ]
