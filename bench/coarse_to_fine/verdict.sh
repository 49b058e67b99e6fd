#!/bin/bash
# bench/coarse_to_fine/verdict.sh [OUT] [SEED...] [-- options of strake_evidence]
# The default against patches alone and the box by sqp: for each seed the twelve problems and the six physical ones, two at
# a time, then verdict.py. By values only the default is fields by model; with gradients (MODE= in front), where the two
# lattices are run as well, fields by sqp. Runs that are there already are not made again: it may be interrupted and
# called again. Seeds 1 to 9 are for development, from 11 on for the verdict: sets 11-13, 21-23, 31-33.
# REFERENCES=landed: patches and box are those of references.csv (by values; commit a81be3b, before there were fields),
# for seeds that it has.
# bench/coarse_to_fine/verdict.sh runs/verdict 11 12 13
# REFERENCES=landed bench/coarse_to_fine/verdict.sh runs/verdict 154 155 156
# bench/coarse_to_fine/verdict.sh runs/try 1 2 -- --triangles 700 --problems wing,local_bump
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-runs/verdict}
[ $# -eq 0 ] || shift
seeds=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    seeds+=("$1")
    shift
done
[ $# -eq 0 ] || shift
[ ${#seeds[@]} -gt 0 ] || seeds=(11 12 13 21 22 23 31 32 33)
options=("$@")
problems=
for ((i = 0; i < ${#options[@]}; ++i)); do
    [ "${options[i]}" = --problems ] || continue
    problems=${options[i + 1]}
    unset 'options[i]' 'options[i + 1]'
    options=("${options[@]}")
    break
done
program=${STRAKE_EVIDENCE:-}
if [ -z "$program" ]; then
    (cd "$root" && cmake --preset bench >/dev/null && ninja -C build/bench --quiet -j "${JOBS:-2}" strake_evidence)
    program=$root/build/bench/bench/coarse_to_fine/strake_evidence
fi
[ -n "$problems" ] ||
    problems=$( ("$program" --list --triangles 1000 && "$program" --list --physical --triangles 1000) | cut -d, -f1 | paste -sd,)
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
mode=${MODE---values-only}
way=as_it_comes method=model
[ -n "$mode" ] || way=fields method=sqp
references=${REFERENCES:-adaptive,ffd}
known=()
if [ "$references" = landed ]; then
    [ -n "$mode" ] || { echo "REFERENCES=landed: references.csv is of runs by values only" >&2; exit 2; }
    known=(--references "$root/bench/coarse_to_fine/references.csv")
fi
for seed in "${seeds[@]}"; do
    folder=$out/seed-$seed
    mkdir -p "$folder"
    run() {
        tr , '\n' <<<"$problems" | xargs -P "${JOBS:-2}" -I{} "$program" --out "$folder" --seed "$seed" \
            --triangles 1500 --budget 1000 ${mode:+"$mode"} "${options[@]}" --problems {} "$@"
    }
    [ "$references" = landed ] || run --methods sqp --solvers "$references"
    python3 "$root/bench/coarse_to_fine/verdict.py" "${known[@]}" --write-enough "$folder"
    run --methods "$method" --solvers "$way" --enough "$folder/enough.csv"
    [ -n "$mode" ] || run --methods sqp --solvers lattice_4x4x4,lattice_8x4x2 --enough "$folder/enough.csv"
done
python3 "$root/bench/coarse_to_fine/verdict.py" "${known[@]}" --way "$way" --way-method "$method" "${seeds[@]/#/$out/seed-}"
