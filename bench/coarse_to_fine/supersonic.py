#!/usr/bin/python3
"""What a cheap model is worth on a supersonic body: supersonic.py OUT [--bin FOLDER] [--only patches|rings]

The body of cases/external/openfoam_supersonic (Mach 2, Euler, OpenFOAM) in its eight patches and in the forty rings of cases/wave_drag, each
- by the area rule alone, without a flow; its best design by the solver;
- by the solver's values alone, 60 evaluations;
- by the solver with the area rule as cheap model, 20 evaluations.
Prints drags over the start's, by the solver and on a mesh of twice the resolution. Runs that have ended in OUT are not made again; those that were
interrupted or killed are resumed.
Needs: scripts/setup.sh openfoam, and cases/external/openfoam_supersonic/prepare.sh.
"""
import argparse
import copy
import csv
import json
import pathlib
import re
import subprocess
import sys

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASE = ROOT / "cases/external/openfoam_supersonic"
BUDGETS = {"area_rule": 200, "values": 60, "low_fidelity": 20}
PARTS = ("patches", "rings")
ENDED = ("converged", "budget", "roundoff", "no_valid_step")  # with a best design
FINER = "2"


def rings(case):
    """The same problem with the variables of cases/wave_drag."""
    with open(ROOT / "cases/wave_drag/case.yaml", encoding="utf-8") as file:
        other = yaml.safe_load(file)
    boxes = {name: region for name, region in other["regions"].items() if re.fullmatch(r"b\d+", name)}
    return {**case, "regions": {**case["regions"], **boxes}, "parameters": other["parameters"]}


def by_way(case, way):
    case = copy.deepcopy(case)
    case["optimize"]["budget"] = {"evaluations": BUDGETS[way]}
    if way == "area_rule":
        del case["quantities"]["drag"]
        case["objective"] = {"minimize": "area_rule"}
        case["optimize"] = {key: value for key, value in case["optimize"].items() if "difference" not in key}
    elif way == "values":
        del case["quantities"]["drag"]["low_fidelity"]
    return case


def num_evaluations(run):
    with open(run / "history.csv", encoding="utf-8") as file:
        return sum(1 for _ in csv.DictReader(file))


def status_of(strake, run):
    """What `strake status` says; best.obj is there while a run goes on, too."""
    return json.loads(subprocess.run([strake, "status", run, "--json"], check=True, stdout=subprocess.PIPE).stdout)


def complete(strake, file, run):
    """Runs the case, unless its run has ended."""
    journal = run / "journal.sqlite"
    if not journal.exists():
        done = subprocess.run([strake, "run", file, "--out", run, "-q"], check=False)
        if not journal.exists():
            sys.exit(f"supersonic.py: {file}: strake ended with status {done.returncode}")
    elif status_of(strake, run)["status"] in ("killed", "interrupted"):
        subprocess.run([strake, "resume", run, "-q"], check=False)
    end = status_of(strake, run)
    if end["status"] not in ENDED:
        sys.exit(f"supersonic.py: {run}: the status of the run is '{end['status']}': {end['reason']}")


def drags(surfaces, out, *words):
    told = subprocess.run([CASE / "wave.py", "rebuild", *words, *surfaces], cwd=out, check=True, stdout=subprocess.PIPE, text=True).stdout
    return [float(line.rsplit(" ", 1)[1]) for line in told.splitlines() if " cells, drag " in line]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/programs", help="folder of strake")
    parser.add_argument("--only", choices=PARTS, help="one of the two sets of variables")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    with open(CASE / "low_fidelity.yaml", encoding="utf-8") as file:
        patches = yaml.safe_load(file)
    start = CASE / "generated/body.obj"
    if not (CASE / "generated/base/0/U").exists():
        sys.exit(f"{CASE}: no mesh yet; run prepare.sh of this folder first")
    ends = {}
    for name in [options.only] if options.only else PARTS:
        for way in BUDGETS:
            run, file = options.out / f"{name}_{way}", CASE / "generated" / f"{name}_{way}.yaml"
            case = by_way(patches if name == "patches" else rings(patches), way)
            case["surface"] = {"file": "body.obj", "units": "m"}
            if "drag" in case["quantities"]:
                case["quantities"]["drag"]["command"][0] = "../wave.py"
            file.write_text(yaml.safe_dump(case, sort_keys=False), encoding="utf-8")
            complete(options.bin / "strake", file, run)
            ends[f"{name}_{way}"] = (run / "best.obj").resolve()
    surfaces = [start, *ends.values()]
    here, finer = drags(surfaces, options.out, "1"), drags(surfaces, options.out, FINER)
    print("| variables and way | evaluations | drag by the solver | on the finer mesh |\n|---|---|---|---|")
    print(f"| start | | {here[0]:.6f} | {finer[0]:.6f} |")
    for i, name in enumerate(ends, 1):
        print(f"| {name} | {num_evaluations(options.out / name)} | {100 * (here[i] / here[0] - 1):.1f} % | {100 * (finer[i] / finer[0] - 1):.1f} % |")


if __name__ == "__main__":
    main()
