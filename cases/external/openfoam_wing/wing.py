#!/usr/bin/python3
"""Drag and lift of a wing at Reynolds number 1e6 by OpenFOAM: Spalart-Allmaras and wall functions, half of the space.

    wing.py REQUEST RESULT                  an evaluation for Strake, in the current folder
    wing.py prepare SURFACE                 builds mesh and start solution about the start shape, in generated/base
    wing.py rebuild FACTOR SURFACE:DEG..    coefficients of surfaces at angles of attack in degrees, on new meshes of
                                            FACTOR times the resolution, one line each, begun from the flow in
                                            generated/base

The angle of attack, `variables.alpha` of the request, turns the stream, not the mesh. The coefficients are those of the
half wing on its area of 0.78.
"""
import json
import math
import os
import re
import shutil
import sys

import numpy as np

HERE = os.path.dirname(os.path.realpath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "../openfoam"))
import flow
import foam

TEMPLATE, BASE = os.path.join(HERE, "foam"), os.path.join(HERE, "generated/base")
CELLS = {"cellsAlong": 20, "cellsAcross": 10, "cellsHigh": 16}  # of the wind tunnel, before refinement
OUTSIDE = {"far": "fixed", "symmetry": "symmetryPlane"}
FIELDS = ["U", "p", "nut", "nuTilda"]
START_ALPHA = math.radians(6)
MEAN = 20      # iterations that the coefficients are averaged over
STEADY = 5e-3  # largest difference between the means of the last iterations and those before


def stream(folder, alpha):
    """The directions of the stream and of the lift, which controlDict and U include."""
    cosine, sine = math.cos(alpha), math.sin(alpha)
    with open(os.path.join(folder, "system/stream"), "w", encoding="ascii") as file:
        file.write(f"along ({cosine!r} 0 {sine!r});\nupward ({-sine!r} 0 {cosine!r});\n")


def turn_stream(folder, alpha):
    """The same in the fields to start from, which hold the far field's values as numbers."""
    stream(folder, alpha)
    path = os.path.join(folder, "0/U")
    with open(path, encoding="ascii") as file:
        text = file.read()
    os.remove(path)
    along = f"({math.cos(alpha)!r} 0 {math.sin(alpha)!r})"
    head, far, rest = text.partition("far\n")
    patch, brace, rest = rest.partition("}")
    patch = re.sub(r"freestreamValue.*?;", f"freestreamValue uniform {along};", patch, flags=re.DOTALL)
    patch = re.sub(r"\bvalue .*?;", f"value uniform {along};", patch, flags=re.DOTALL)
    with open(path, "w", encoding="ascii") as file:
        file.write(head + far + patch + brace + rest)


def solve(folder, iterations):
    flow.steps(folder, iterations)
    foam.run(folder, "simpleFoam")
    values = {}
    for name, column in (("drag", "Cd"), ("lift", "Cl")):
        history = flow.coefficients(folder, column)
        values[name] = float(history[-MEAN:].mean())
        change = abs(history[-2 * MEAN:-MEAN].mean() - values[name])
        if not change <= STEADY * abs(values[name]):
            foam.fail(f"{name} is not steady after {iterations} iterations: {values[name]:.5g}, changed by {change:.2g}")
    return values


def both_sides(surface):
    """The half model and its mirror image: the mesher then meets a closed wing, of which it keeps a half."""
    vertices, triangles = surface
    return np.vstack([vertices, vertices * [1, -1, 1]]), np.vstack([triangles, triangles[:, ::-1] + len(vertices)])


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    flow.move(BASE, "case", foam.read_obj(request["surface"])[0], OUTSIDE, half=1)
    turn_stream("case", request["variables"]["alpha"])
    with open(result_file, "w", encoding="ascii") as file:
        json.dump({"values": solve("case", 120)}, file)
    flow.clean("case")


def build(folder, surface, alpha, sizes):
    template = folder + "-template"
    shutil.rmtree(template, ignore_errors=True)
    shutil.copytree(TEMPLATE, template)
    stream(template, alpha)
    cells = flow.build(template, folder, both_sides(surface), sizes)
    shutil.rmtree(template)
    return cells


def y_plus(folder):
    with open(os.path.join(folder, "log.simpleFoam"), encoding="utf-8") as file:
        told = re.findall(r"patch body y\+ : min = (\S+), max = (\S+), average = (\S+)", file.read())
    return "y+ {} to {}, {} in the mean".format(*told[-1]) if told else "y+ unknown"


def prepare(file):
    """The flow about the start shape is where every evaluation starts."""
    surface = foam.read_obj(file)
    cells = build(BASE, surface, START_ALPHA, CELLS)
    distance = flow.save_map(BASE, surface)
    values = solve(BASE, 300)
    flow.start_from(BASE, FIELDS)
    print(f"{cells} cells, boundary within {distance:.1e} of the diagonal from the surface, {y_plus(BASE)}, {values}")


def rebuild(factor, files):
    sizes = flow.refined(CELLS, factor)
    for name in files:
        file, degrees = name.rsplit(":", 1)
        cells = build("rebuilt", foam.read_obj(file), math.radians(float(degrees)), sizes)
        flow.start_near(BASE, "rebuilt")
        turn_stream("rebuilt", math.radians(float(degrees)))
        print(f"{name}: {cells} cells, {solve('rebuilt', round(150 * float(factor)))}, {y_plus('rebuilt')}", flush=True)
        flow.clean("rebuilt")


if __name__ == "__main__":
    flow.command_line(__doc__, prepare, rebuild, evaluate)
