#!/usr/bin/python3
"""Wave drag of a body in a supersonic stream without friction, by OpenFOAM's rhoCentralFoam on half of the space.

    wave.py REQUEST RESULT            an evaluation for Strake, in the current folder
    wave.py prepare SURFACE           builds mesh and start solution about the start shape, in generated/base
    wave.py rebuild FACTOR SURFACE..  drag of surfaces on new meshes of FACTOR times the resolution, one line each,
                                      begun from the flow in generated/base

The drag is that over dynamic pressure and the square of the unit of length; the stream comes along x at Mach 2.
"""
import json
import os
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "../openfoam"))
import flow
import foam

TEMPLATE, BASE = os.path.join(HERE, "foam"), os.path.join(HERE, "generated/base")
CELLS = {"cellsAlong": 36, "cellsAcross": 24, "cellsHigh": 12}  # of the wind tunnel, before refinement
OUTSIDE = {"inlet": "fixed", "outlet": "fixed", "symmetry": "symmetryPlane"}
FIELDS = ["U", "p", "T"]
MEAN = 100       # steps: the limiter leaves a ripple of 1e-4, which the mean takes out
STEADY = 5e-3    # largest difference between the means of the last steps and those before


def solve(folder, steps):
    """Time steps to the steady flow, each cell with its own; returns the drag."""
    flow.steps(folder, steps)
    foam.run(folder, "rhoCentralFoam")
    history = flow.coefficients(folder)
    last, before = history[-MEAN:].mean(), history[-2 * MEAN:-MEAN].mean()
    if not abs(last - before) <= STEADY * abs(last):
        foam.fail(f"not steady after {steps} steps: drag {before:.6g}, then {last:.6g}")
    return float(last)


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    flow.move(BASE, "case", foam.read_obj(request["surface"])[0], OUTSIDE, half=2)
    result = {"value": solve("case", 350)}
    with open(result_file, "w", encoding="ascii") as file:
        json.dump(result, file)
    flow.clean("case")


def prepare(file):
    """The flow about the start shape is where every evaluation starts."""
    surface = foam.read_obj(file)
    cells = flow.build(TEMPLATE, BASE, surface, CELLS)
    distance = flow.save_map(BASE, surface)
    drag = solve(BASE, 1000)
    flow.start_from(BASE, FIELDS)
    print(f"{cells} cells, boundary within {distance:.1e} of the diagonal from the surface, drag {drag:.6f}")


def rebuild(factor, files):
    sizes = flow.refined(CELLS, factor)
    for file in files:
        cells = flow.build(TEMPLATE, "rebuilt", foam.read_obj(file), sizes)
        flow.start_near(BASE, "rebuilt")
        print(f"{file}: {cells} cells, drag {solve('rebuilt', round(250 * float(factor))):.6f}", flush=True)
        flow.clean("rebuilt")


if __name__ == "__main__":
    flow.command_line(__doc__, prepare, rebuild, evaluate)
