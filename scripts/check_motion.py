#!/usr/bin/python3
"""Measures how far the shapes of a run are from their datum: check_motion.py RUN... [--strake PROGRAM] [--limit SHARE]
or on real bodies: check_motion.py --bodies DATA --out FOLDER [--strake PROGRAM] [--limits 0.5,2,5] [--evaluations N]

The datum is computed by `strake deform` from the case of the run: the surface under the given loads and strains. Measured
are all surfaces that the run has kept: evaluations/*/surface.obj of a program (every evaluation), series/*.vtp and best.*.
Prints one line a run: limit, shapes, the farthest vertex as a share of the limit, and its number.
With --bodies the runs are made first: `strake init` writes the case of each body, whose volume is then made small, and a
program that does nothing keeps every shape.
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
    with tempfile.TemporaryDirectory() as folder:
        datum_file = os.path.join(folder, "datum.obj")
        subprocess.run([strake, "deform", os.path.join(run, "case.yaml"), "-o", datum_file, "-q"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        datum = read_obj(datum_file)
    with open(os.path.join(run, "run.json"), encoding="utf-8") as file:
        result = json.load(file)
    checked = json.loads(subprocess.run([strake, "check", os.path.join(run, "case.yaml"), "--json", "--quick"], check=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)
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


def make_run(body, share, args):
    """@return the run folder."""
    name = os.path.splitext(os.path.basename(body))[0] + f"_{share:g}"
    run, case = os.path.join(args.out, name), os.path.join(args.out, name + ".yaml")
    subprocess.run([args.strake, "init", body, "-o", case], check=True, stdout=subprocess.DEVNULL)
    with open(case, encoding="utf-8") as file:
        text = file.read()
    text = re.sub(r"max_displacement: \S+", f"max_displacement: {share:g}%", text)
    text = re.sub(r"(?ms)^(quantities|objective|constraints|optimize|output):.*?(?=^\S|\Z)", "", text)
    text += ("quantities:\n  room: {type: volume}\n  keep: {command: [sh, -c, \"echo '{\\\"value\\\": 1}' > {result}\"], "
             "format: obj, gradients: false}\n"
             "objective: {minimize: room}\n"
             f"optimize: {{budget: {{evaluations: {args.evaluations}}}{args.method}}}\n"
             "output: {keep: all, paraview: none, report: false}\n")
    with open(case, "w", encoding="utf-8") as file:
        file.write(text)
    subprocess.run([args.strake, "run", case, "--out", run, "-q"], check=False, stdout=subprocess.DEVNULL)
    return run


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
    args = parser.parse_args()
    if bool(args.bodies) == bool(args.runs) or (args.bodies and not args.out):
        parser.error("either runs, or --bodies and --out")
    args.method = f", method: {args.method}" if args.method else ""
    runs = args.runs
    if args.bodies:
        os.makedirs(args.out, exist_ok=True)
        bodies = [os.path.join(args.bodies, name) for name in BODIES if args.only in name]
        runs = (make_run(body, float(share), args) for body in bodies for share in args.limits.split(","))
    is_within = True
    for run in runs:
        is_within &= measure(run, args.strake, args.limit)
    return 0 if is_within else 1


if __name__ == "__main__":
    sys.exit(main())
