#!/usr/bin/python3
"""Wave drag of a slender body in a supersonic stream without friction, by OpenFOAM's rhoCentralFoam on half of the space.

    wave.py REQUEST RESULT                  an evaluation for Strake, in the current folder
    wave.py prepare SURFACE                 mesh and flow about the start shape, in generated/base
    wave.py rebuild FACTOR SURFACE[:MACH]..  drag of surfaces on meshes of FACTOR times the resolution, one line each,
                                            begun from the flow in generated/base

The drag is that of the whole body over dynamic pressure: an area in the square of the surface's unit. The stream comes along x at
Mach 2, or at MACH. The mesh is the one of openfoam/around.py, made of the surface anew each time, with the same cells.
"""
import json
import math
import os
import re
import shutil
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "../openfoam"))
import around
import flow
import foam

TEMPLATE, BASE = os.path.join(HERE, "foam"), os.path.join(HERE, "generated/base")
CELLS = {"along": 40, "wake": 6, "around": 4, "outward": 14}
MACH = 2.0
FIELDS = ["U", "p", "T"]
MEAN = 100       # steps: the limiter leaves a ripple of 1e-3, which the mean takes out
STEADY = 5e-3    # largest difference between the means of the last steps and those before


def layout(surface, sizes, mach):
    """The outer cone is a little wider than that of a weak wave."""
    x = surface[0][:, 0]
    return around.Layout(sizes, (x.min(), x.max()), 1.15 / math.sqrt(mach * mach - 1))


def solve(folder, steps):
    """Time steps to the steady flow, each cell with its own; returns the drag. Flows that are far from the one they begin at get up
    to four times as many steps."""
    for last_step in range(steps, 4 * steps + 1, steps):
        flow.steps(folder, last_step)
        foam.run(folder, "rhoCentralFoam")
        history = flow.coefficients(folder)
        last, before = history[-MEAN:].mean(), history[-2 * MEAN:-MEAN].mean()
        if abs(last - before) <= STEADY * abs(last):
            return float(last)
    foam.fail(f"not steady after {last_step} steps: drag {before:.6g}, then {last:.6g}")


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        surface = foam.read_obj(json.load(file)["surface"])
    if not os.path.exists(os.path.join(BASE, "0/U")):
        foam.fail(f"{BASE}: no mesh yet; run prepare.sh of this folder first")
    shutil.rmtree("case", ignore_errors=True)
    flow.clone(BASE, "case")
    os.remove("case/constant/polyMesh/points")  # the base's
    foam.write_points("case/constant/polyMesh", layout(surface, CELLS, MACH).points(surface))
    flow.check("case")
    with open(result_file, "w", encoding="ascii") as file:
        json.dump({"value": solve("case", 250)}, file)
    flow.clean("case")


def build(folder, surface, sizes, mach):
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(TEMPLATE, folder)
    with open(os.path.join(folder, "system/stream"), "w", encoding="ascii") as file:
        file.write(f"mach {mach!r};\n")
    cells = layout(surface, sizes, mach)
    points, mesh = cells.points(surface), os.path.join(folder, "constant/polyMesh")
    around.write_topology(mesh, cells, points)
    foam.write_points(mesh, points)
    return flow.check(folder)


def prepare(file):
    """The flow about the start shape is where every evaluation starts."""
    cells = build(BASE, foam.read_obj(file), CELLS, MACH)
    drag = solve(BASE, 900)
    flow.start_from(BASE, FIELDS)
    print(f"{cells} cells, drag {drag:.6f}")


def rebuild(factor, files):
    sizes = flow.refined(CELLS, factor)
    for name in files:
        file, _, mach = name.partition(":")
        cells = build("rebuilt", foam.read_obj(file), sizes, float(mach or MACH))
        flow.start_near(BASE, "rebuilt")
        print(f"{name}: {cells} cells, drag {solve('rebuilt', round(400 * float(factor))):.6f}", flush=True)
        flow.clean("rebuilt")


if __name__ == "__main__":
    flow.command_line(__doc__, prepare, rebuild, evaluate)
