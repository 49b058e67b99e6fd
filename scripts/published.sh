#!/bin/bash
# Problems with published answers (cases/published): published.sh [--write] [--quick] [BIN] [NAME...] runs those named, or all,
# and prints ours beside what is published; exit status 1 where one is missed.
# BIN holds strake (default: build/release/programs). --write: the tables of docs/published.md, which then needs all of them;
# --quick: the small sizes of the tests.
cd "$(dirname "$0")/.." || exit 1
python=python3
[ ! -x /usr/bin/python3 ] || python=/usr/bin/python3  # the one that has Debian's numpy
exec "$python" scripts/published.py "$@"
