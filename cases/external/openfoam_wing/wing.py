#!/usr/bin/python3
"""Drag and lift of a wing at Reynolds number 1e6 by OpenFOAM: Spalart-Allmaras and wall functions, half of the space.

    wing.py REQUEST RESULT                  an evaluation for Strake, in the current folder
    wing.py prepare SURFACE                 builds mesh and flow about a plain wing, in generated/base
    wing.py rebuild FACTOR PLAIN FILE:DEG.. coefficients of surfaces at angles of attack in degrees, on a mesh of FACTOR
                                            times the resolution, made about the plain wing and moved to the others,
                                            one line each; the first begins from the flow in generated/base, each
                                            other from the one before

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
import around_wing
import flow
import foam

TEMPLATE, BASE = os.path.join(HERE, "foam"), os.path.join(HERE, "generated/base")
CELLS = {"chord": 24, "wake": 10, "span": 12, "tip": 3, "outward": 24}
FIRST = 1.4e-3  # thickness of the cells at the wall
FIELDS = ["U", "p", "nut", "nuTilda"]
START_ALPHA = math.radians(6)
MEAN = 20      # iterations that the coefficients are averaged over
FROM_REST = 200  # iterations from the uniform stream
FINE = 250, 150  # of the first surface on a finer mesh, and of those after it, whose flow is near
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


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    evaluate_surface(foam.read_obj(request["surface"])[0], request["variables"]["alpha"], result_file)


def evaluate_surface(vertices, alpha, result_file):
    move(BASE, "case", vertices)
    flow.check("case")
    turn_stream("case", alpha)
    with open(result_file, "w", encoding="ascii") as file:
        json.dump({"values": solve("case", 100)}, file)
    flow.clean("case")


def layout(factor):
    return around_wing.Layout(flow.refined(CELLS, factor), FIRST / factor)


def build(folder, surface, alpha, factor):
    """A mesh about the surface, tied to it; returns the number of cells."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(TEMPLATE, folder)
    stream(folder, alpha)
    made, mesh = layout(factor), os.path.join(folder, "constant/polyMesh")
    carried, on_wing, distance = made.wing(surface)
    points = made.points(on_wing)
    around_wing.write_topology(mesh, made, points)
    foam.write_points(mesh, points)
    np.savez(os.path.join(folder, "map.npz"), vertices=surface[0], corners=carried.corners, weights=carried.weights,
             on_wing=on_wing, factor=factor)
    return flow.check(folder), distance


def move(base, folder, vertices):
    """The base's case in `folder` with the mesh about a wing of the same vertices."""
    stored, carried = flow.read_map(base)
    if len(vertices) != carried.num_vertices:
        foam.fail(f"the surface has {len(vertices)} vertices, the one that the mesh was made about "
                  f"{carried.num_vertices}; run prepare.sh again")
    shutil.rmtree(folder, ignore_errors=True)
    flow.clone(base, folder)
    shift = carried.apply(vertices - stored["vertices"])
    shift[stored["on_wing"][:, 1] == 0, 1] = 0
    os.remove(os.path.join(folder, "constant/polyMesh/points"))  # the base's
    points = layout(float(stored["factor"])).points(stored["on_wing"] + shift)
    foam.write_points(os.path.join(folder, "constant/polyMesh"), points)


def y_plus(folder):
    with open(os.path.join(folder, "log.simpleFoam"), encoding="utf-8") as file:
        told = re.findall(r"patch body y\+ : min = (\S+), max = (\S+), average = (\S+)", file.read())
    return "y+ {} to {}, {} in the mean".format(*told[-1]) if told else "y+ unknown"


def prepare(file):
    """The flow about the plain wing is where every evaluation starts."""
    cells, distance = build(BASE, foam.read_obj(file), START_ALPHA, 1)
    values = solve(BASE, FROM_REST)
    flow.start_from(BASE, FIELDS)
    print(f"{cells} cells, boundary within {distance:.1e} of the diagonal from the surface, {y_plus(BASE)}, {values}")


def rebuild(factor, files):
    base, folder = (os.path.join(HERE, "generated", name) for name in ("rebuilt-base", "rebuilt"))
    cells, _ = build(base, foam.read_obj(files[0]), START_ALPHA, float(factor))
    flow.start_near(BASE, base)
    shutil.copy(os.path.join(base, "system/couplingOfFineMesh"), os.path.join(base, "system/coupling"))
    for n, (file, degrees) in enumerate(name.rsplit(":", 1) for name in files[1:]):
        move(base, folder, foam.read_obj(file)[0])
        turn_stream(folder, math.radians(float(degrees)))
        values = solve(folder, FINE[min(n, 1)])
        print(f"{file}:{degrees}: {cells} cells, {values}, {y_plus(folder)}", flush=True)
        flow.start_from(folder, FIELDS)
        for name in FIELDS:
            shutil.copyfile(os.path.join(folder, "0", name), os.path.join(base, "0", name))
        flow.clean(folder)


if __name__ == "__main__":
    flow.command_line(__doc__, prepare, rebuild, evaluate)
