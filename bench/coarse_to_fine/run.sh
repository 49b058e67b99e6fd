#!/bin/bash
# bench/coarse_to_fine/run.sh [OUT] [options of strake_evidence]
# Builds the evidence suite, solves all problems in every way, and writes traces (CSV), table.md, data profiles (SVG)
# and the final patches of the adaptive runs (VTP) to OUT (default: runs/evidence).
# JOBS=2: two problems at a time; CPU seconds are those of one process with one thread each.
# ./run.sh runs/seed2 --seed 2       the second set
# ./run.sh runs/smoke --triangles 800 --budget 20 --problems wing,local_bump
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
out=runs/evidence
if [ $# -gt 0 ] && [[ $1 != --* ]]; then
    out=$1
    shift
fi
problems=
options=()
while [ $# -gt 0 ]; do
    if [ "$1" = --problems ]; then
        problems=$2
        shift 2
    else
        options+=("$1")
        shift
    fi
done
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
(cd "$root" && cmake --preset bench "${launcher[@]}" >/dev/null && ninja -C build/bench --quiet -j "${JOBS:-1}" strake_evidence)
program=$root/build/bench/bench/coarse_to_fine/strake_evidence
[ -n "$problems" ] || problems=$("$program" --list --triangles 1000 | cut -d, -f1 | paste -sd,)
mkdir -p "$out"
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
tr , '\n' <<<"$problems" | xargs -P "${JOBS:-1}" -I{} "$program" --out "$out" --problems {} "${options[@]}"
python3 "$root/bench/coarse_to_fine/profile.py" "$out"
echo "$out/table.md"
