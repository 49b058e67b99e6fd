#!/usr/bin/python3
"""Drag of a body in a laminar stream by OpenFOAM, with the gradient by its adjoint solver.

    drag.py REQUEST RESULT            an evaluation for Strake, in the current folder
    drag.py prepare SURFACE           builds mesh and start solution about the start shape, in generated/base
    drag.py rebuild FACTOR SURFACE..  drag of surfaces on new meshes of FACTOR times the resolution, one line each

The drag is that over dynamic pressure and the square of the unit of length; the stream comes along x with speed 1.
"""
import json
import os
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "../openfoam"))
import domain
import flow
import foam
from mesh import Mesh

TEMPLATE, BASE = os.path.join(HERE, "foam"), os.path.join(HERE, "generated/base")
CELLS = {"cellsAlong": 24, "cellsAcross": 18}  # of the wind tunnel, before refinement
OUTSIDE = {"inlet": "fixed", "outlet": "fixed", "sides": "symmetry"}  # what they do when the mesh moves
ITERATIONS = 1500
VISCOSITY = 0.005  # as in transportProperties: Reynolds number 200


def solve(folder):
    """The flow; returns the drag."""
    flow.steps(folder, ITERATIONS)
    told = foam.run(folder, "simpleFoam")
    if "SIMPLE solution converged" not in told:
        foam.fail(f"the flow has not converged in {ITERATIONS} iterations")
    return float(flow.coefficients(folder)[-1])


def adjoint(folder):
    """The adjoint of the drag, beside the flow in the last time folder."""
    flow.start_from(folder, ["U", "p", "phi"])
    flow.steps(folder, 2 * ITERATIONS)
    told = foam.run(folder, "adjointOptimisationFoam")
    if told.count("solution converged in") < 2 and told.count("converged") < 2:
        foam.fail(f"the adjoint has not converged in {ITERATIONS} iterations")


def by_body(folder):
    """The derivative of the drag by the points of the body, in OpenFOAM's order."""
    mesh, fields = Mesh.read(os.path.join(folder, "constant/polyMesh")), os.path.join(folder, flow.latest(folder))
    body = foam.patch_range(os.path.join(folder, "constant/polyMesh"), "body")
    read = lambda name, components: foam.read_cell_field(os.path.join(fields, name), components)
    on_wall = -foam.read_patch_field(os.path.join(fields, "Ua"), "body", 3)  # Ua is the adjoint times -1
    everywhere, _ = domain.by_points(mesh, (read("U", 3), read("p", 1)[:, 0]), (-read("Ua", 3), -read("pa", 1)[:, 0]), body,
                                     on_wall, VISCOSITY)
    rows = mesh.corners[mesh.first[body[0]]:mesh.first[body[-1] + 1]]
    return domain.Motion(mesh, body).transpose(everywhere)[list(dict.fromkeys(rows.tolist()))]


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    carried = flow.move(BASE, "case", foam.read_obj(request["surface"])[0], OUTSIDE)
    result = {"value": solve("case")}
    if request["wanted"]["gradients"]:
        adjoint("case")
        with open("gradient.csv", "w", encoding="ascii") as file:
            for k, (x, y, z) in enumerate(carried.transpose(by_body("case")).tolist()):
                file.write(f"{k},{x!r},{y!r},{z!r}\n")
        result["gradient"] = "gradient.csv"
    with open(result_file, "w", encoding="ascii") as file:
        json.dump(result, file)
    flow.clean("case")


def prepare(file):
    """The solution about the start shape is where every evaluation starts: sooner done, and always the same."""
    surface = foam.read_obj(file)
    cells = flow.build(TEMPLATE, BASE, surface, CELLS)
    distance = flow.save_map(BASE, surface)
    drag = solve(BASE)
    adjoint(BASE)
    flow.start_from(BASE, ["U", "p", "Ua", "pa"])
    os.remove(os.path.join(BASE, "0/phi"))  # of the mesh at rest
    print(f"{cells} cells, boundary within {distance:.1e} of the diagonal from the surface, drag {drag:.6f}")


def rebuild(factor, files):
    sizes = flow.refined(CELLS, factor)
    for file in files:
        cells = flow.build(TEMPLATE, "rebuilt", foam.read_obj(file), sizes)
        print(f"{file}: {cells} cells, drag {solve('rebuilt'):.6f}", flush=True)
        flow.clean("rebuilt")


if __name__ == "__main__":
    flow.command_line(__doc__, prepare, rebuild, evaluate)
