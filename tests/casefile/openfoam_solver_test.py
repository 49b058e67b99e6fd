#!/usr/bin/python3
"""The drag example with OpenFOAM itself, on a mesh as small as it can be: openfoam_solver_test.py FOLDER_OF_THE_EXAMPLE
Ends with 77, which ctest counts as skipped, where OpenFOAM is not installed."""
import json
import os
import shutil
import sys
import tempfile

if not shutil.which("simpleFoam"):
    print("skipped: simpleFoam is not installed (scripts/setup.sh openfoam)")
    sys.exit(77)
import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv.pop(1))
import drag
from body_surface import sphere


def write_obj(path, vertices, triangles):
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %r %r %r\n" % tuple(row) for row in vertices.tolist())
        file.writelines("f %d %d %d\n" % tuple(row) for row in (triangles + 1).tolist())


def evaluate(vertices, triangles, gradients):
    os.makedirs("evaluation")
    os.chdir("evaluation")
    write_obj("surface.obj", vertices, triangles)
    with open("request.json", "w", encoding="ascii") as file:
        json.dump({"surface": "surface.obj", "wanted": {"values": ["value"], "gradients": gradients}}, file)
    drag.evaluate("request.json", "result.json")
    with open("result.json", encoding="ascii") as file:
        value = json.load(file)["value"]
    gradient = np.loadtxt("gradient.csv", delimiter=",")[:, 1:] if gradients else None
    os.chdir("..")
    shutil.rmtree("evaluation")
    return value, gradient


def main():
    vertices, triangles = sphere(20, 24)
    vertices = vertices * [0.5, 0.35, 0.35]
    drag.CELLS = {"cellsAlong": 12, "cellsAcross": 9}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        drag.BASE = os.path.join(folder, "base")
        write_obj("body.obj", vertices, triangles)
        drag.prepare("body.obj")
        value, gradient = evaluate(vertices, triangles, ["value"])
        again, _ = evaluate(vertices, triangles, [])
        assert value == again, f"not repeatable: {value}, then {again}"
        thicker = vertices * [0, 1, 1]
        step = 0.01
        values = [evaluate(vertices + s * step * thicker, triangles, [])[0] for s in (1, -1)]
        os.chdir("/")
    slope, difference = float(np.sum(gradient * thicker)), (values[0] - values[1]) / (2 * step)
    print(f"drag {value}, slope by the adjoint {slope:.4f}, by differences {difference:.4f}")
    assert 0.2 < value < 0.6, value
    assert 0.9 < slope / difference < 1.1, "the adjoint is far off, even for so coarse a mesh"


if __name__ == "__main__":
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    main()
