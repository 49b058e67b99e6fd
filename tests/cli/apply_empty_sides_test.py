"""A run whose sections stay the same (`invariance: {extrude: y}`) and the two-dimensional mesh about it: apply_empty_sides_test.py
STRAKE EXAMPLES. Both sides of the moved mesh are one plane drawing, bit by bit, and no cell turns inside out; where OpenFOAM
is installed, checkMesh is content with the empty sides and sees two directions."""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

STRAKE, EXAMPLES = sys.argv[1:3]
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(EXAMPLES, "openfoam"))
import around
import foam

AROUND, OUTWARD, FAR = 64, 24, 6.0

CASE = """case: section
surface: {file: section.obj}
parameters: {fields: 12, patches_per_level: [4], variables: [normal], max_displacement: 4%}
invariance: {extrude: y}
hold: point
quantities: {change: {type: displacement}}
objective: {maximize: change}
constraints: {area: {max: 1.02, relative: true}}
optimize: {budget: {evaluations: 8}}
"""


def section(angle):
    return np.array([0.5 * math.cos(angle), 0.12 * math.sin(angle) * (1 - 0.4 * math.cos(angle))])


def write_surface(path):
    """A column of two vertices for each point of the section, open at both sides."""
    with open(path, "w", encoding="ascii") as file:
        for i in range(AROUND):
            x, z = section(2 * math.pi * i / AROUND)
            file.write(f"v {x!r} 0 {z!r}\nv {x!r} 0.1 {z!r}\n")
        for i in range(AROUND):
            a, b = 2 * i + 1, 2 * ((i + 1) % AROUND) + 1
            file.write(f"f {a} {a + 1} {b}\nf {b} {a + 1} {b + 1}\n")


def write_mesh(folder):
    """One layer of cells about it, from the section to a circle."""
    points, node = [], np.empty((AROUND, OUTWARD + 1, 2), dtype=int)
    for i in range(AROUND):
        angle = 2 * math.pi * i / AROUND
        near, far = section(angle), FAR * np.array([math.cos(angle), math.sin(angle)])
        for j in range(OUTWARD + 1):
            t = (math.exp(4 * j / OUTWARD) - 1) / (math.exp(4) - 1)
            x, z = (1 - t) * near + t * far
            for k, y in enumerate((0.0, 0.1)):
                node[i, j, k] = len(points)
                points.append((x, y, z))
    points = np.array(points)
    cell = np.arange(AROUND * OUTWARD).reshape(AROUND, OUTWARD)
    following = np.roll(node, -1, axis=0)
    at = np.stack([points[n[:, j:OUTWARD + j, k]] for n in (node, following) for j in (0, 1) for k in (0, 1)])
    middle = at.mean(axis=0).reshape(-1, 3)
    none = np.full(cell.shape, -1)

    def quads(a, b, c, d):
        return np.stack([a, b, c, d], axis=-1)

    radial = quads(node[:, :-1, 0], node[:, 1:, 0], node[:, 1:, 1], node[:, :-1, 1])
    ring = quads(node[:, :, 0], following[:, :, 0], following[:, :, 1], node[:, :, 1])
    side = [quads(node[:, :-1, k], node[:, 1:, k], following[:, 1:, k], following[:, :-1, k]) for k in (0, 1)]
    parts = {"": [(radial, cell, np.roll(cell, 1, axis=0)), (ring[:, 1:-1], cell[:, :-1], cell[:, 1:])],
             "body": [(ring[:, 0], cell[:, 0], none[:, 0])], "far": [(ring[:, -1], cell[:, -1], none[:, -1])],
             "sides": [(side[0], cell, none), (side[1], cell, none)]}
    parts = {name: around.joined(rows, points, middle) for name, rows in parts.items()}
    rows, owner, neighbour = parts[""]
    order = np.lexsort((neighbour, owner))
    parts[""] = rows[order], owner[order], neighbour[order]
    around.write_parts(folder, parts)
    foam.write_points(folder, points)
    boundary = os.path.join(folder, "boundary")
    with open(boundary, encoding="ascii") as file:
        text = file.read()
    with open(boundary, "w", encoding="ascii") as file:
        file.write(text.replace("sides { type patch", "sides { type empty"))
    return node


def told(*command):
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 0, (command, done.returncode, done.stderr)
    return json.loads(done.stdout)


def checked(folder):
    os.makedirs(os.path.join(folder, "system"))
    with open(os.path.join(folder, "system/controlDict"), "w", encoding="ascii") as file:
        file.write(foam.header("dictionary", "controlDict") +
                   "application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
                   "writeControl timeStep; writeInterval 1;\n")
    for name in ("fvSchemes", "fvSolution"):
        with open(os.path.join(folder, "system", name), "w", encoding="ascii") as file:
            file.write(foam.header("dictionary", name) + "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {}\n")
    return foam.run(folder, "checkMesh", "-constant")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        write_surface("section.obj")
        node = write_mesh("start/constant/polyMesh")
        with open("case.yaml", "w", encoding="ascii") as file:
            file.write(CASE)
        run = told(STRAKE, "run", "case.yaml", "--out", "run", "--json")
        os.makedirs("moved/constant")
        applied = told(STRAKE, "apply", "run", "start", "-o", "moved/constant/polyMesh", "--json")
        assert applied["cells"]["checked"] == AROUND * OUTWARD and applied["cells"]["newly_bad"] == 0, applied
        before, after = (foam.read_points(os.path.join(name, "constant/polyMesh")) for name in ("start", "moved"))
        moved = np.linalg.norm(after - before, axis=1)
        assert moved.max() > 0.02, (moved.max(), run)
        low, high = after[node[:, :, 0]], after[node[:, :, 1]]
        assert (low[..., [0, 2]] == high[..., [0, 2]]).all(), np.abs(low - high)[..., [0, 2]].max()
        assert (low[..., 1] == 0).all() and (high[..., 1] == 0.1).all(), "the sides are planes"
        words = "checkMesh is not installed (scripts/setup.sh openfoam)"
        if shutil.which("checkMesh"):
            for name in ("start", "moved"):
                text = checked(name)
                assert "Mesh OK" in text, text
                assert "Mesh has 2 geometric (non-empty/wedge) directions (1 0 1)" in text, text
            words = "checkMesh: OK, two directions"
        os.chdir("/")
    print(f"moved by up to {moved.max():.3g} of a chord; {words}")


if __name__ == "__main__":
    main()
