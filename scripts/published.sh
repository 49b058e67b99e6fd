#!/bin/bash
# Problems with published answers (cases/published): published.sh [--write] [--quick] [--budget N] [--bin BIN] [NAME...] runs those named, or all,
# and prints ours beside what is published; exit status 1 where one is missed and docs/published.md does not say why.
# BIN holds strake (default: build/release/programs). --write: their rows in the table of docs/published.md; --quick: as the tests run them;
# --budget: evaluations of each run, to try a command.
cd "$(dirname "$0")/.." || exit 1
python=python3
[ ! -x /usr/bin/python3 ] || python=/usr/bin/python3  # the one that has Debian's numpy
exec "$python" scripts/published.py "$@"
