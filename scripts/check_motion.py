#!/usr/bin/python3
"""Measures how far the shapes of a run are from their datum: check_motion.py RUN... [--strake PROGRAM] [--limit SHARE]
or on real bodies: check_motion.py --bodies DATA --out FOLDER [--strake PROGRAM] [--limits 0.5,2,5] [--evaluations N]
                   [--method NAME] [--edge-length SHARE] [--grow] [--small] [--compare | --inactive] [--only PART]

The datum is computed by `strake deform` from the case of the run: the surface under the given loads and strains. Measured
are all surfaces that the run has kept: evaluations/*/surface.obj of a program (every evaluation), series/*.vtp and best.*.
Prints one line a run: limit, shapes, the farthest vertex as a share of the limit, and its number.
With --bodies the runs are made first: `strake init` writes the case of each body, whose volume is then made small (of open ones the
highest point high), and a program that does nothing keeps every shape. --edge-length remeshes the bodies in the case, in percent of the diagonal.
--grow: the volume is made large, which no fold ends before the limit does. --small: 4, then 12 patches, or 12 fields without shell in place of a wrap.
--compare: the gain of each run against the best of three methods, from two starts, with three times the evaluations.
--inactive: a goal that the limit does not touch (2 % less volume, of open bodies 0.2 % more height), under 5 % and without limit in the same
variables.
Exit status: 0 all shapes are within their limit (1e-9), 1 one is not, 2 wrong usage.
"""

import argparse
import json
import os
import re
import struct
import subprocess
import sys
import tempfile

import numpy

BODIES = ["cessna210_flowpanel.msh", "wing717_pyhyp.ply", "dpw_w1_pypan.tri", "supersonic_wing_body_pypan.stl",
          "bunny_closed_cgal.off"]
OPEN = ["wing717_pyhyp.ply", "dpw_w1_pypan.tri"]
TOLERANCE = 1e-9


def read_obj(path):
    """n x 3, exact: the file has all digits."""
    with open(path, encoding="utf-8") as lines:
        return numpy.array([[float(word) for word in line.split()[1:4]] for line in lines if line.startswith("v ")])


def read_vtp(path):
    """The points of Strake's own .vtp: the first appended array, doubles behind a length of eight bytes."""
    with open(path, "rb") as file:
        data = file.read()
    count = int(re.search(rb'NumberOfPoints="(\d+)"', data).group(1))
    points = re.search(rb"<Points>.*?</Points>", data, re.S).group(0)
    offset = int(re.search(rb'offset="(\d+)"', points).group(1))
    begin = data.index(b"_", data.index(b"<AppendedData")) + 1 + offset
    wide = b'header_type="UInt64"' in data
    size = struct.unpack_from("<Q" if wide else "<I", data, begin)[0]
    if size != 24 * count:
        raise ValueError(f"{path}: {size} bytes for {count} points")
    return numpy.frombuffer(data, "<f8", 3 * count, begin + (8 if wide else 4)).reshape(-1, 3)


def shapes_of(run):
    found = []
    for folder, _, files in os.walk(run):
        for name in files:
            if name == "surface.obj" or name.endswith(".vtp") and os.path.basename(folder) == "series":
                found.append(os.path.join(folder, name))
    best = os.path.join(run, "best.obj")
    return sorted(found) + ([best] if os.path.exists(best) else [])


def measure(run, strake, limit):
    case = os.path.join(run, "case.yaml")
    checked = json.loads(subprocess.run([strake, "check", case, "--json", "--quick"], check=True, stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL).stdout)
    with open(case, encoding="utf-8") as file:
        has_shell = not re.search(r"^shell: none", file.read(), re.M)
    resting = [] if has_shell else ["--field", checked["fields"][0] + "=0"]  # deform wants something that moves
    with tempfile.TemporaryDirectory() as folder:
        datum_file = os.path.join(folder, "datum.obj")
        subprocess.run([strake, "deform", case, "-o", datum_file, "-q", *resting], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        datum = read_obj(datum_file)
    with open(os.path.join(run, "run.json"), encoding="utf-8") as file:
        result = json.load(file)
    diagonal = checked["surface"]["diagonal"]
    if limit is None:
        limit = result["motion_limit"]["limit"]
    worst, vertex, count = 0.0, -1, 0
    for path in shapes_of(run):
        points = read_obj(path) if path.endswith(".obj") else read_vtp(path)
        if len(points) != len(datum):
            raise ValueError(f"{path}: {len(points)} vertices, the datum has {len(datum)}")
        moved = numpy.linalg.norm(points - datum, axis=1)
        count += 1
        if moved.max() > worst:
            worst, vertex = moved.max(), int(moved.argmax())
    used = worst / (limit * diagonal)
    print(f"{run}: limit {100 * limit:g} %, {count} shapes, farthest {used:.12f} of it at vertex {vertex}; "
          f"{result['status']}, {result['evaluations']} evaluations, {result['objective_start']:.8g} to "
          f"{result['objective']:.8g}", flush=True)
    return count > 0 and used <= 1 + TOLERANCE


def make_run(body, share, args, label="", evaluations=0, optimize="", goal="", limit="", keeps_shapes=True):
    """@return the run folder."""
    stem = os.path.splitext(os.path.basename(body))[0]
    name = stem + f"_{share:g}" + label
    run, case, proposed = (os.path.join(args.out, part) for part in (name, name + ".yaml", stem + ".yaml"))
    if not os.path.exists(proposed):
        subprocess.run([args.strake, "init", body, "-o", proposed], check=True, stdout=subprocess.DEVNULL)
    with open(proposed, encoding="utf-8") as file:
        text = file.read()
    text = re.sub(r"max_displacement: \S+", limit or f"max_displacement: {share:g}%", text)
    text = re.sub(r"(?ms)^(quantities|objective|constraints|optimize|output):.*?(?=^\S|\Z)", "", text)
    if args.small:
        text = re.sub(r"patches_per_level: \[[^]]*\]", "patches_per_level: [4, 12]", text)
        text = re.sub(r"(?m)^wrap: .*$", "shell: none", text).replace("fields: auto", "fields: 12")
        if "shell: none" in text:
            text = re.sub(r"(?m)^  (variables|patches_per_level): .*\n", "", text)
    if args.edge_length:
        text = re.sub(r"(?m)^  mirror: .*\n", "", text)  # new triangles need not be mirror images
        text = re.sub(r"(?ms)^remesh:.*?(?=^\S|\Z)", "", text) + f"remesh: {{edge_length: {args.edge_length:g}%}}\n"
    is_open = os.path.basename(body) in OPEN
    up = {"x": "[1, 0, 0]", "y": "[0, 1, 0]", "z": "[0, 0, 1]"}[re.search(r"(?m)^axes: .*up: .(\w)", text).group(1)]
    kind = f"extent, direction: {up}, smoothing: 5%" if is_open else "volume"
    goal = goal or ("'-room.max'" if is_open else "'-room'" if args.grow else "room")
    keep = ("  keep: {command: [sh, -c, \"echo '{\\\"value\\\": 1}' > {result}\"], format: obj, gradients: false}\n"
            if keeps_shapes else "")
    text += (f"quantities:\n  room: {{type: {kind}}}\n{keep}"
             f"objective: {{minimize: {goal}}}\n"
             f"optimize: {{budget: {{evaluations: {evaluations or args.evaluations}}}{optimize or args.method}}}\n"
             "output: {keep: all, paraview: none, report: false}\n")
    with open(case, "w", encoding="utf-8") as file:
        file.write(text)
    subprocess.run([args.strake, "run", case, "--out", run, "-q"], check=False, stdout=subprocess.DEVNULL)
    return run


def result_of(run):
    with open(os.path.join(run, "run.json"), encoding="utf-8") as file:
        return json.load(file)


def compare(body, share, args):
    """The run against the best of three methods, two starts, three times the budget: its share of that gain."""
    run = make_run(body, share, args)
    is_within = measure(run, args.strake, args.limit)
    own = result_of(run)
    gains = {}
    for method in ["cobyla", "bobyqa", "sbplx"] if args.method else ["sqp", "mma", "lbfgs"]:
        for starts in (1, 2):
            other = make_run(body, share, args, f"_{method}_{starts}", 3 * args.evaluations,
                             f", method: {method}" + (", starts: 2" if starts == 2 else ""), keeps_shapes=False)
            result = result_of(other)
            print(f"    {method}, {starts}: {result['status']}, {result['evaluations']} evaluations, {result['objective']:.8g}")
            gains[f"{method}, {starts} start{'s' if starts == 2 else ''}"] = result["objective_start"] - result["objective"]
    best = max(gains, key=gains.get)
    start = own["objective_start"]
    print(f"  {os.path.basename(body)} at {share:g} %: gain {start - own['objective']:.8g}, the best ({best}) {gains[best]:.8g}; "
          f"share {(start - own['objective']) / gains[best]:.4f}; objectives differ by "
          f"{100 * abs(own['objective'] - start + gains[best]) / abs(start - gains[best]):.3f} %", flush=True)
    return is_within


def without_active_limit(body, args):
    is_open = os.path.basename(body) in OPEN
    size = "room.max" if is_open else "room"
    start = result_of(make_run(body, 5, args, "_start", 1, goal=size, keeps_shapes=False))["objective_start"]
    goal = f"'({size} / {start:.17g} - {1.002 if is_open else 0.98})^2'"
    results = []
    for label, limit in (("_under", "max_displacement: 5%"), ("_free", "max_displacement: 100%\n  variable_scale: 5%")):
        run = make_run(body, 5, args, label, 5 * args.evaluations, goal=goal, limit=limit, keeps_shapes=False)
        results.append(result_of(run))
        result = results[-1]
        print(f"{run}: {result['status']}, {result['evaluations']} evaluations, {result['objective_start']:.8g} to "
              f"{result['objective']:.8g}, limit active: {result.get('motion_limit', {}).get('active')}", flush=True)
    gain = [r["objective_start"] - r["objective"] for r in results]
    return abs(gain[0] / gain[1] - 1) <= 1e-3 and results[0]["evaluations"] <= 1.1 * results[1]["evaluations"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*")
    parser.add_argument("--strake", default="strake")
    parser.add_argument("--limit", type=float, help="share of the diagonal (default: what run.json says)")
    parser.add_argument("--bodies", help="folder with the surfaces")
    parser.add_argument("--out", help="folder for cases and runs")
    parser.add_argument("--limits", default="0.5,2,5", help="percent of the diagonal")
    parser.add_argument("--evaluations", type=int, default=12)
    parser.add_argument("--method", default="", help="method without gradients, for example cobyla")
    parser.add_argument("--only", default="", help="part of a body's name")
    parser.add_argument("--edge-length", type=float, default=0, help="percent of the diagonal: remesh the bodies")
    parser.add_argument("--grow", action="store_true")
    parser.add_argument("--small", action="store_true")
    parser.add_argument("--compare", action="store_true")
    parser.add_argument("--inactive", action="store_true")
    args = parser.parse_args()
    if bool(args.bodies) == bool(args.runs) or (args.bodies and not args.out):
        parser.error("either runs, or --bodies and --out")
    args.method = f", method: {args.method}" if args.method else ""
    runs = args.runs
    if args.bodies:
        os.makedirs(args.out, exist_ok=True)
        bodies = [os.path.join(args.bodies, name) for name in BODIES if args.only in name]
        shares = [float(share) for share in args.limits.split(",")]
        if args.compare:
            return 0 if all([compare(body, share, args) for body in bodies for share in shares]) else 1
        if args.inactive:
            return 0 if all([without_active_limit(body, args) for body in bodies]) else 1
        runs = (make_run(body, share, args) for body in bodies for share in shares)
    is_within = True
    for run in runs:
        is_within &= measure(run, args.strake, args.limit)
    return 0 if is_within else 1


if __name__ == "__main__":
    sys.exit(main())
