#!/usr/bin/python3
"""Dirty bodies from the file to a finished run: dirty_bodies.py --out FOLDER [--strake PROGRAM] [--make-surface PROGRAM]
                       [--data FOLDER] [--evaluations N] [--seconds T] [--only PART] [--seed N]

For each body `strake init FILE`, then `strake run` of what it wrote, and beside it the same by displacement fields alone (shell: none).
The goal is the one of `init`: volume under an area and a mean motion, or where nothing encloses a volume the area.
Bodies: twelve of make_surface, with --data also eight real ones. Prints one line a body, and at the end what they have in common:
way, gain in percent (of fields alone), evaluations, failed designs, patches in use, seconds of init and run, verdict.
Exit status: 0 every body came to an end with a gain, 1 one did not, 2 wrong usage.
"""

import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import time

MADE = ["crossing_boxes", "crossing_cylinders", "wing_through_body", "cad_slivers", "gaps", "t_junctions", "flipped_parts",
        "doubled_faces", "holes", "inner_walls", "zero_areas", "rough_cut"]
REAL = ["of_motorBike.obj.gz", "generic_twin_manifold.obj", "citationX_raw.ply", "wing_c172_pygeo.stl", "x43_parts.ply",
        "threeplugs_pynastran.tri", "three_element_wing_cpanel.tri", "two_objects_mixed_case_trimesh.stl"]


def call(command, seconds):
    """@return status, seconds, the last line that was said."""
    begin = time.time()
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return 124, seconds, f"not finished in {seconds:g} s"
    words = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    return done.returncode, time.time() - begin, words[-1] if words else ""


def way_of(case):
    if re.search(r"^shell: none", case, re.M):
        return "fields"
    if re.search(r"^wrap: ", case, re.M):
        return "wrap"
    return "remeshed shell" if re.search(r"^remesh:", case, re.M) else "shell"


def by_fields(case):
    """The same case without patches and whatever they need."""
    case = re.sub(r"(?m)^(wrap|hold):.*\n", "", case)
    case = re.sub(r"(?m)^  (variables|patches_per_level|levels|sharp_angle):.*\n", "", case)
    case = re.sub(r"(?m)^shell:\n(  .*\n)*", "", case)
    case = case.replace("\nparameters:\n", "\nshell: none\nparameters:\n")
    return case if "fields:" in case else case.replace("\nparameters:\n", "\nparameters:\n  fields: auto\n")


def result_of(run):
    """Gain in percent, designs, failed ones, whether patches move the best design, and the verdict."""
    with open(os.path.join(run, "run.json"), encoding="utf-8") as file:
        result = json.load(file)
    with open(os.path.join(run, "history.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    start, end = result["objective_start"], result["objective"]
    failed = sum(row["status"] not in ("ok", "taken_over") for row in rows)
    patches = False
    best = os.path.join(run, "levels", "best.csv")
    if os.path.exists(best):
        with open(best, encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                patches |= int(row["patch"]) >= 0 and abs(float(row["x"])) > 1e-6  # fields have no patch
    gain = 100 * abs(end - start) / abs(start) if start and end is not None else 0
    return {"gain": gain, "designs": len(rows), "failed": failed, "patches": patches, "verdict": result["status"]}


def run_case(case, run, args):
    status, seconds, words = call([args.strake, "run", case, "--out", run, "--quiet", "--set",
                                   f"optimize.budget={{evaluations: {args.evaluations}}}"], args.seconds)
    if not os.path.exists(os.path.join(run, "run.json")):
        return None, seconds, words
    try:
        return result_of(run), seconds, words
    except (OSError, ValueError, KeyError) as error:
        return None, seconds, f"status {status}: {error}"


def one_body(name, path, args):
    stem = os.path.join(args.out, name)
    for old in (stem + ".yaml", stem + "-patches.svg", stem + "-patches.vtp"):
        if os.path.exists(old):
            os.remove(old)
    status, init_seconds, words = call([args.strake, "init", path, "-o", stem + ".yaml", "-q"], args.seconds)
    if status != 0:
        print(f"{name:36} init: status {status}: {words}", flush=True)
        return False, False, False
    with open(stem + ".yaml", encoding="utf-8") as file:
        case = file.read()
    shutil.rmtree(stem, ignore_errors=True)
    shutil.rmtree(stem + "-fields", ignore_errors=True)
    found, run_seconds, words = run_case(stem + ".yaml", stem, args)
    if found is None:
        print(f"{name:36} {way_of(case):8} run: {words}", flush=True)
        return False, False, False
    other = None
    if way_of(case) != "fields":
        with open(stem + "-fields.yaml", "w", encoding="utf-8") as file:
            file.write(by_fields(case))
        other, _, _ = run_case(stem + "-fields.yaml", stem + "-fields", args)
    beside = f"{other['gain']:8.3f}" if other else " " * 7 + "-"
    print(f"{name:36} {way_of(case):8} gain {found['gain']:8.3f} % (fields {beside}), {found['failed']:2} of {found['designs']:3} failed, "
          f"patches {'yes' if found['patches'] else 'no '}, init {init_seconds:5.1f} s, run {run_seconds:5.1f} s, {found['verdict']}", flush=True)
    return found["gain"] > 0, 10 * found["failed"] < found["designs"], found["patches"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--strake", default="strake")
    parser.add_argument("--make-surface", default="make_surface")
    parser.add_argument("--data")
    parser.add_argument("--evaluations", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    args = parser.parse_args()
    os.makedirs(args.out, exist_ok=True)
    bodies = [(name, None) for name in MADE]
    if args.data:
        bodies += [(name.split(".")[0], os.path.join(args.data, name)) for name in REAL]
    counts = [0, 0, 0]
    tried = 0
    for name, path in bodies:
        if args.only not in name:
            continue
        if path is None:
            path = os.path.join(args.out, name + ".obj")
            subprocess.run([args.make_surface, name, "--seed", str(args.seed), "-o", path], check=True, stdout=subprocess.DEVNULL)
        tried += 1
        for k, is_so in enumerate(one_body(name, path, args)):
            counts[k] += is_so
    print(f"{tried} bodies: {counts[0]} with a gain, {counts[1]} with less than a tenth of designs failed, {counts[2]} with patches in use")
    sys.exit(0 if counts[0] == tried else 1)


if __name__ == "__main__":
    main()
