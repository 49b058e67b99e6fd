"""`strake apply` moves the viscous mesh of a wing whose planform changes: apply_planform_test.py STRAKE MAKE_SURFACE EXAMPLES.
The mesh has first cells of 1e-5 of the chord, as OpenFOAM's polyMesh, SU2 and VTU, with all of span, sweep, twist, dihedral and chord."""
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

STRAKE, MAKE_SURFACE, EXAMPLES = sys.argv[1:4]
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(EXAMPLES, "openfoam"))
import around_wing
import foam
from mesh import Mesh

CASE = """case: wing
surface: {file: wing.obj}
symmetry: {plane: y, at: 0}
planform: {wing: {span: y, stations: [0, 0.5, 1]}}
shell: none
parameters:
  planform:
    wing.span: {range: [-10%, 10%]}
    wing.sweep: {range: [-5deg, 5deg]}
    wing.dihedral: {range: [-5deg, 5deg]}
    wing.chord: {by: station, range: [-10%, 10%]}
    wing.twist: {by: station, range: [-5deg, 5deg]}
objective: {maximize: volume}
"""
SIZES = {"chord": 10, "wake": 4, "span": 6, "tip": 2, "outward": 34}
FIRST = 0.8e-5
ENDS = {"span": "10%", "sweep": "5deg", "dihedral": "5deg", "chord": "10%", "twist": "5deg"}


def changes(names, sign):
    fields = []
    for name in names:
        for station in ("@0", "@0.5", "@1") if name in ("chord", "twist") else ("",):
            fields += ["--field", f"wing.delta_{name}{station}={sign}{ENDS[name]}"]
    return fields


def told(*command, status=0):
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == status, (command, done.returncode, done.stderr)
    return json.loads(done.stdout) if "--json" in command else done.stderr


def deformed(fields):
    """A run folder with one design, that of these changes."""
    os.makedirs("run/series", exist_ok=True)
    os.makedirs("run/levels", exist_ok=True)
    with open("run/case.yaml", "w", encoding="ascii") as file:
        file.write(CASE.replace("wing.obj", os.path.abspath("wing.obj")))
    open("run/levels/best.design", "w", encoding="ascii").close()
    told(STRAKE, "deform", "run/case.yaml", "-o", "run/series/design_000001.vtp", *fields)


def orthogonality(mesh):
    """The angle between a face's normal and the line through the middles of its cells, degrees."""
    line = mesh.middles[mesh.neighbour] - mesh.middles[mesh.owner[:mesh.inner]]
    area = mesh.areas[:mesh.inner]
    cosine = np.einsum("ij,ij->i", line, area) / np.linalg.norm(line, axis=1) / np.linalg.norm(area, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def hexahedra(layout):
    node = layout.number
    corners = [node[i:node.shape[0] - 1 + i, j:node.shape[1] - 1 + j, k:node.shape[2] - 1 + k]
               for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return np.stack(corners, axis=-1).reshape(-1, 8)


def write_su2(path, points, cells):
    with open(path, "w", encoding="ascii") as file:
        file.write(f"NDIME= 3\nNELEM= {len(cells)}\n")
        file.writelines("12 " + " ".join(map(str, cell)) + "\n" for cell in cells)
        file.write(f"NPOIN= {len(points)}\n")
        file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
        file.write("NMARK= 0\n")


def write_vtu(path, points, cells):
    rows = lambda values: " ".join(map(repr, np.asarray(values).ravel().tolist()))
    array = lambda kind, name, values, more="": f'<DataArray type="{kind}" Name="{name}"{more} format="ascii">{rows(values)}</DataArray>'
    with open(path, "w", encoding="ascii") as file:
        file.write('<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>'
                   f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}"><Points>'
                   + array("Float64", "Points", points, ' NumberOfComponents="3"') + "</Points><Cells>"
                   + array("Int64", "connectivity", cells) + array("Int64", "offsets", 8 * np.arange(1, len(cells) + 1))
                   + array("UInt8", "types", np.full(len(cells), 12)) + "</Cells></Piece></UnstructuredGrid></VTKFile>")


def read_su2(path):
    with open(path, encoding="ascii") as file:
        words = file.read().split("NPOIN=")[1].split("NMARK=")[0].split()
    return np.array(words[1:], dtype=float).reshape(-1, 3)


def apply(mesh, out, *more):
    return told(STRAKE, "apply", "run", mesh, "-o", out, "--evaluation", "1", "--json", *more)


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        told(MAKE_SURFACE, "wing", "--triangles", "3000", "-o", "wing.obj")
        layout = around_wing.Layout(SIZES, FIRST)
        _, on_wing, _ = layout.wing(foam.read_obj("wing.obj"))
        points = layout.points(on_wing)
        around_wing.write_topology("mesh", layout, points)
        foam.write_points("mesh", points)
        start = Mesh.read("mesh")
        before = orthogonality(start)
        on_plane, far = np.abs(points[:, 1]) < 1e-12, np.linalg.norm(points - [1, 0.6, 0], axis=1) > 5
        assert on_plane.sum() > 500 and far.sum() > 50
        for names in (["span"], ["sweep"], ["twist"], list(ENDS)):
            for sign in ("", "-"):
                deformed(changes(names, sign))
                applied = apply("mesh", "moved", "--reach", "2")
                assert applied["cells"]["checked"] == 28 * 8 * 34 and applied["cells"]["newly_bad"] == 0, (names, applied)
                mesh = Mesh.read("moved")
                after, size = orthogonality(mesh), mesh.volumes / start.volumes
                assert mesh.volumes.min() > 0 and size.min() > 0.45 and size.max() < 1.9, (names, sign, size.min(), size.max())
                assert np.percentile(after, 99) < np.percentile(before, 99) + (8 if len(names) > 1 else 4), (names, sign)
                moved = foam.read_points("moved")
                assert np.abs(moved[on_plane, 1]).max() == 0, "the plane of symmetry is one"
                assert np.array_equal(moved[far], points[far]), "what is far stays to the bit"
                assert np.abs(moved - points).max() > 0.03
                print(names, sign or "+", "volumes", size.min().round(3), size.max().round(3), "orthogonality, 99 %",
                      np.percentile(before, 99).round(1), np.percentile(after, 99).round(1))
        # The other formats go to the same places.
        cells = hexahedra(layout)
        write_su2("mesh.su2", points, cells)
        write_vtu("mesh.vtu", points, cells)
        assert apply("mesh.su2", "moved.su2", "--reach", "2")["cells"]["checked"] == len(cells)
        assert apply("mesh.vtu", "moved.vtu", "--reach", "2")["cells"]["newly_bad"] == 0
        assert np.abs(read_su2("moved.su2") - moved).max() < 1e-14
        # Vertices of the surface get their bits.
        apply("wing.obj", "wing_moved.vtp")
        told(STRAKE, "deform", "run/case.yaml", "-o", "exact.obj", *changes(list(ENDS), "-"))
        apply("wing.obj", "through.obj")
        with open("exact.obj", encoding="ascii") as one, open("through.obj", encoding="ascii") as other:
            assert [r for r in one if r.startswith("v ")] == [r for r in other if r.startswith("v ")]
        # --undo returns; of all five changes at once two points of 8 525 have two origins, 2e-4 apart.
        deformed(changes(["twist"], "-"))
        apply("mesh", "moved", "--reach", "2", "--force")
        undone = apply("moved", "back", "--reach", "2", "--undo", "--force")
        assert undone["undo"]["unsolved"] == 0, undone
        assert np.abs(foam.read_points("back") - points).max() < 1e-9
        os.chdir("/")


if __name__ == "__main__":
    main()
