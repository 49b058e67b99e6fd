#!/usr/bin/python3
"""A wing that pierces a body, taken to both ends of its sweep, dihedral and twist: does the body stay, is the joint closed?

    joint.py [--strake PROGRAM] [--out DIR] [--sweep 8] [--dihedral 6] [--twist 5]

Half a body of revolution with a wing of its own whose root rib lies inside. Each end is searched by `strake run`, with all
three at once. Prints how many of the body's vertices moved at all, how deep the rib still lies inside, and how often each
line of the wing from root to tip crosses the body: once is a closed joint. Ends with 1 where it is not.
"""
import argparse
import math
import pathlib
import shutil
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from found_wings import read_obj  # noqa: E402
from kept_edges import loft  # noqa: E402

AROUND, ROWS, ROOT, TIP = 64, 30, 0.12, 2.52
CASE = """case: pierced
surface: {file: pierced.obj}
symmetry: {plane: y, at: 0}
planform:
  wing: {on: wing, span: y, stations: [0, 0.4, 1]}
shell: none
parameters:
  planform:
    wing.sweep: {range: [-%(sweep)gdeg, %(sweep)gdeg]}
    wing.dihedral: {range: [-%(dihedral)gdeg, %(dihedral)gdeg]}
    wing.twist: {by: station, range: [-%(twist)gdeg, %(twist)gdeg]}
objective: {%(way)s: "wing.sweep + wing.dihedral + wing.twist@0 + wing.twist@1 + wing.twist@0.4"}
constraints: {volume: {min: 0.1, relative: true}}
optimize: {budget: {evaluations: 12}}
"""


def body(around=24, along=60):
    """Half an ellipsoid of revolution, open at y = 0."""
    points, faces = [[-0.2, 0, 0], [4.2, 0, 0]], []
    for i in range(1, along):
        t = math.pi * i / along
        for j in range(around + 1):
            p = math.pi * j / around
            points.append([2 - 2.2 * math.cos(t), 0 if j in (0, around) else 0.36 * math.sin(t) * math.sin(p),
                           0.36 * math.sin(t) * math.cos(p)])
    ring = lambda i, j: 2 + (i - 1) * (around + 1) + j  # noqa: E731
    for j in range(around):
        faces += [(0, ring(1, j), ring(1, j + 1)), (1, ring(along - 1, j + 1), ring(along - 1, j))]
        for i in range(1, along - 1):
            a, b, c, d = ring(i, j), ring(i + 1, j), ring(i, j + 1), ring(i + 1, j + 1)
            faces += [(a, b, c), (c, b, d)]
    return numpy.array(points, float), numpy.array(faces)


def make(folder):
    rows = [(numpy.array([1.65 + 0.35 * (y - ROOT), y, 0.05 * (y - ROOT)]), 0.0, 1 - 0.2 * (y - ROOT), 0.05 - 0.025 * (y - ROOT))
            for y in numpy.linspace(ROOT, TIP, ROWS)]
    loft(str(folder / "wing.obj"), rows, around=AROUND)
    points, faces = read_obj(folder / "wing.obj")
    rib = [(a - (ROWS - 1) * AROUND, c - (ROWS - 1) * AROUND, b - (ROWS - 1) * AROUND) for a, b, c in faces
           if min(a, b, c) >= (ROWS - 1) * AROUND]
    faces = numpy.vstack([faces, rib])
    more, others = body()
    with open(folder / "pierced.obj", "w") as out:
        out.writelines("v %.12g %.12g %.12g\n" % tuple(p) for p in numpy.vstack([points, more]))
        for name, group, shift in (("wing", outward(points, faces), 1), ("body", outward(more, others), 1 + len(points))):
            out.write(f"g {name}\n")
            out.writelines("f %d %d %d\n" % tuple(t + shift) for t in group)
    return len(points)


def outward(points, faces):
    volume = numpy.einsum("ij,ij->i", points[faces[:, 0]], numpy.cross(points[faces[:, 1]], points[faces[:, 2]])).sum()
    return faces if volume > 0 else faces[:, [0, 2, 1]]


def depth(points, faces, x):
    """Inside of the closed half body and its mirror image: distance to it, else negative. By solid angles."""
    total, nearest = 0.0, math.inf
    for flip in (1, -1):
        corner = [(points[faces[:, k]] * (1, flip, 1)) - x for k in range(3)]
        size = [numpy.linalg.norm(c, axis=1) for c in corner]
        solid = numpy.einsum("ij,ij->i", corner[0], numpy.cross(corner[1], corner[2])) * flip
        total += (2 * numpy.arctan2(solid, size[0] * size[1] * size[2] + numpy.einsum("ij,ij->i", corner[0], corner[1]) * size[2]
                                    + numpy.einsum("ij,ij->i", corner[1], corner[2]) * size[0]
                                    + numpy.einsum("ij,ij->i", corner[2], corner[0]) * size[1])).sum()
        nearest = min(nearest, size[0].min())
    return nearest if total > 2 * math.pi else -nearest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--strake", default="strake")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/joint"))
    for name, most in (("sweep", 8), ("dihedral", 6), ("twist", 5)):
        parser.add_argument("--" + name, type=float, default=most, help="degrees")
    options = parser.parse_args()
    shutil.rmtree(options.out, ignore_errors=True)
    options.out.mkdir(parents=True)
    count = make(options.out)
    closed = True
    for way in ("maximize", "minimize"):
        (options.out / f"{way}.yaml").write_text(CASE % dict(vars(options), way=way))
        words = subprocess.run([options.strake, "check", f"{way}.yaml"], cwd=options.out, capture_output=True, text=True).stdout
        notes = [line for line in words.splitlines() if line.startswith("note")]
        subprocess.run([options.strake, "run", f"{way}.yaml", "--out", way, "-q"], cwd=options.out, check=True,
                       stdout=subprocess.DEVNULL)
        before, faces = read_obj(options.out / "pierced.obj")
        after, _ = read_obj(options.out / way / "best.obj")
        lines = [line for line in (options.out / "pierced.obj").read_text().split("g body")[0].splitlines() if line[:1] == "f"]
        skin = faces[len(lines):]
        wing = numpy.unique(faces[:len(lines)])
        moved = int((before[numpy.setdiff1d(numpy.arange(len(before)), wing)]
                     != after[numpy.setdiff1d(numpy.arange(len(after)), wing)]).any(1).sum())
        inside = [[depth(after, skin, after[r * AROUND + k]) > 0 for r in range(0, ROWS)] for k in range(0, AROUND, 4)]
        crossings = {sum(a != b for a, b in zip(line, line[1:])) for line in inside}
        rib = min(depth(after, skin, after[k]) for k in range(AROUND))
        tip = after[(ROWS - 1) * AROUND:ROWS * AROUND].mean(0) - before[(ROWS - 1) * AROUND:ROWS * AROUND].mean(0)
        print(f"{way}: tip moved by {tip[0]:+.3f} aft, {tip[2]:+.3f} up; {moved} of {len(before) - len(wing)} vertices of the body "
              f"moved; rib {rib:.4f} inside; crossings of a line from root to tip: {sorted(crossings)}")
        for note in notes:
            print("  " + note)
        closed = closed and moved == 0 and crossings == {1} and rib > 0 and count == len(wing)
    return 0 if closed else 1


if __name__ == "__main__":
    sys.exit(main())
