#!/usr/bin/env python3
"""The libraries neither print nor end the process: what their object files call. quiet_libraries_test.py ARCHIVE...

`_exit` is allowed in objectives: in the child between fork and exec."""
import pathlib
import subprocess
import sys

FORBIDDEN = {"exit", "abort", "_exit", "_Exit", "quick_exit", "printf", "vprintf", "puts", "putchar", "perror", "stdout",
             "stderr", "__printf_chk", "__fprintf_chk", "__vfprintf_chk", "std::cout", "std::cerr", "std::clog",
             "std::terminate()"}
ALLOWED = {"libstrake_objectives.a": {"_exit"}}
# What the compiler itself adds to functions that may not throw.
COMPILERS = {"std::terminate()"}


def called(archive):
    listed = subprocess.run(["nm", "-uC", archive], check=True, capture_output=True, text=True).stdout
    names = set()
    for line in listed.splitlines():
        words = line.split(maxsplit=1)
        if len(words) == 2 and words[0] == "U":
            names.add(words[1].split("@")[0])
    return names


archives = [pathlib.Path(a) for a in sys.argv[1:]]
bad, seen = [], 0
for archive in archives:
    names = called(archive)
    seen += len(names)
    loud = (names & FORBIDDEN) - COMPILERS - ALLOWED.get(archive.name, set())
    if loud:
        bad.append(f"{archive.name} calls {', '.join(sorted(loud))}")
if len(archives) < 6 or seen < 100:
    bad.append(f"{len(archives)} archives with {seen} names: not what was to be looked at")
print("\n".join(bad) or f"{len(archives)} libraries are quiet")
sys.exit(1 if bad else 0)
