#!/bin/bash
# The wing's two cases from bare surface to optimized shape, at reduced size: main_job.sh BIN TRIANGLES
# Fails unless both converge, the fit recovers its target, and the volume grows within the area allowed.
set -euo pipefail
cd "$(dirname "$0")/.."
bin=$1 triangles=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/cases"
for name in wing lifting_body; do
    mkdir "$work/cases/$name"
    cp cases/$name/*.yaml "$work/cases/$name"
done
scripts/examples.sh "$work/cases" "$bin" "$triangles" 4000
cd "$work"
"$bin/strake" fit cases/wing/fit.yaml --out fit --json >fit.json
"$bin/strake" run cases/wing/case.yaml --out run --json >run.json
python3 - <<'PYTHON'
import csv
import json
import sys

problems = []
for name in ("fit", "run"):
    with open(f"{name}.json") as file:
        end = json.load(file)
    print(name, {key: end.get(key) for key in ("status", "reason", "level", "evaluations", "objective", "max_violation")})
    if end.get("status") not in ("converged", "progress", "roundoff"):
        problems.append(f"{name} ended with status {end.get('status')!r}: {end.get('reason')}")
    with open(f"{name}/history.csv") as file:
        rows = list(csv.DictReader(file))
    levels = {row["level"] for row in rows}
    if len(levels) < 3:
        problems.append(f"{name} has rows of levels {sorted(levels)}, expected three")
    first, best = float(rows[0]["objective"]), float(end["objective"])
    print(f"{name}: objective {first:.6g} -> {best:.6g}")
    if name == "fit" and not best < 1e-4 * first:
        problems.append(f"the fit's objective fell from {first} to {best} only")
    if name == "run" and not best > 1.05 * first:
        problems.append(f"the volume went from {first} to {best} only, expected 5 % more")
    if name == "run" and not end["max_violation"] <= 1e-6:
        problems.append(f"the area constraint is violated by {end['max_violation']}")
print(*problems, sep="\n")
sys.exit(1 if problems else 0)
PYTHON
