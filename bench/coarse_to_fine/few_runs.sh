#!/bin/bash
# bench/coarse_to_fine/few_runs.sh OUT BUDGET SEED... [-- options of strake_evidence]
# What BUDGET evaluations without gradients buy: what a case gets that states no variables, against Bezier boxes of about 12 and 24
# variables by the same optimizer, the first by CMA-ES, too, and patches by differences, cobyla and bobyqa. For each seed the twelve problems, two at a
# time, then few_runs.py. Runs that are there already are not made again. Seeds 1 to 9 are for development, from 11 on for verdicts.
# bench/coarse_to_fine/few_runs.sh runs/few 100 21 22 23
# bench/coarse_to_fine/few_runs.sh runs/noise 100 21 22 23 -- --noise 1e-2
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$1 budget=$2
shift 2
seeds=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do
    seeds+=("$1")
    shift
done
[ $# -eq 0 ] || shift
program=${STRAKE_EVIDENCE:-}
if [ -z "$program" ]; then
    (cd "$root" && cmake --preset bench >/dev/null && ninja -C build/bench --quiet -j "${JOBS:-2}" strake_evidence)
    program=$root/build/bench/bench/coarse_to_fine/strake_evidence
fi
problems=$("$program" --list --triangles 1000 | cut -d, -f1)
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
folders=()
for seed in "${seeds[@]}"; do
    folder=$out/seed-$seed
    folders+=("$folder")
    mkdir -p "$folder"
    run() {  # SOLVERS METHODS
        xargs -P "${JOBS:-2}" -I{} "$program" --out "$folder" --seed "$seed" --values-only --triangles 600 --budget "$budget" \
            --solvers "$1" --methods "$2" "${options[@]}" --problems {} <<<"$problems"
    }
    options=("$@")
    run as_it_comes model
    run box_12,box_24,cma_es_12 model
    run uniform sqp,cobyla,bobyqa
done
python3 "$root/bench/coarse_to_fine/few_runs.py" "$budget" "${folders[@]}"
