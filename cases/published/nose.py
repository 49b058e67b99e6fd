#!/usr/bin/python3
"""Drag of a nose in a supersonic stream without friction: OpenFOAM's rhoCentralFoam on a sector of 5 degrees.

    nose.py MACH REQUEST RESULT              an evaluation for Strake, in the current folder
    nose.py MACH SURFACE.obj [FACTOR]        the drag coefficient, on a mesh of FACTOR times the resolution

The profile is cut out of the full body: at each station of the mesh, the radius of the circle of the section's area. The coefficient is
that of the pressure ahead of the base, on the base's area. Lines of points leave the body outward; the first one leaves the tip,
upstream, so blunt and sharp tips have the same mesh. Needs: scripts/setup.sh openfoam
"""
import json
import math
import os
import shutil
import sys

sys.dont_write_bytecode = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, "../external/openfoam"))
import around  # noqa: E402
import flow  # noqa: E402
import foam  # noqa: E402
from areas import section_area  # noqa: E402

SECTOR = math.radians(5)
ALONG, OUTWARD = 40, 24  # cells
STAGES = ((0.3, 800), (0.2, 400))  # Courant numbers and steps
MEAN = 100     # steps: the limiter leaves a ripple, which the mean takes out
STEADY = 1e-3  # largest difference between the means of the last steps and those before


def profile(surface, stations):
    """Radius at shares of the length, the tip first."""
    vertices, triangles = surface
    begin, end = vertices[:, 0].min(), vertices[:, 0].max()
    corners = vertices[triangles]
    x = begin + (end - begin) * stations
    inside = np.minimum(x[1:], end - 1e-9 * (end - begin))  # the base is flat
    return x, np.concatenate([[0], [math.sqrt(section_area(corners, at) / math.pi) for at in inside]])


def mesh_points(surface, along, outward, mach):
    """x and radius of the points, lines x places outward."""
    stations = (np.arange(along + 1) / along) ** 1.4  # fine where a blunt tip turns
    x, r = profile(surface, stations)
    length = x[-1] - x[0]
    ahead = 0.05 * (1 - np.exp(-stations / 0.05))
    slope = 1 / math.sqrt(mach * mach - 1) + 0.14  # outside of the bow wave
    outer_x = x + length * (ahead - 0.05)
    outer_r = slope * length * np.sqrt((stations + ahead) * (stations + ahead + 0.1))
    first = 0.6 * length / along / np.hypot(outer_x - x, outer_r - r)
    share = around.graded(np.minimum(first, 1 / outward), outward)
    return tuple(a[:, None] + share * (b - a)[:, None] for a, b in ((x, outer_x), (r, outer_r)))


def write_mesh(folder, x, r):
    """The sector's polyMesh. Points on the axis, which are those of the first line, belong to both sides."""
    lines, places = x.shape
    i, side, k = np.meshgrid(np.arange(lines), (0, 1), np.arange(places), indexing="ij")
    kept, number = np.unique(((np.where(i == 0, 0, side) * lines + i) * places + k).ravel(), return_inverse=True)
    node = number.reshape(i.shape)
    turn = (side - 0.5) * SECTOR
    points = np.empty((len(kept), 3))
    points[number] = np.stack([x[i, k], r[i, k] * np.cos(turn), r[i, k] * np.sin(turn)], axis=-1).reshape(-1, 3)
    around.write_block(folder, node, points, ((None, "outlet"), ("back", "front"), ("body", "inlet")))
    foam.write_points(folder, points)


CHANGES = {  # of the supersonic example: a sector's sides in place of a plane of symmetry, and what keeps blunt tips steady
    "0/U": [("symmetry { type symmetryPlane; }", "front { type wedge; }\n    back { type wedge; }")],
    "0/p": [("symmetry { type symmetryPlane; }", "front { type wedge; }\n    back { type wedge; }")],
    "0/T": [("symmetry { type symmetryPlane; }", "front { type wedge; }\n    back { type wedge; }")],
    "system/controlDict": [("maxCo             0.4;", "maxCo $courant;"), ("rDeltaTSmoothingCoeff 0.1;", "rDeltaTSmoothingCoeff 1;")],
    "system/fvSchemes": [("Kurganov", "Tadmor"), ("vanAlbada", "Minmod")],
}


def prepare(folder, surface, mach, factor):
    """A case of OpenFOAM's: gas, scheme and forces of the supersonic example with these changes; returns the sector's base."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(os.path.join(HERE, "../external/openfoam_supersonic/foam"), folder)
    for name, changes in CHANGES.items():
        path = os.path.join(folder, name)
        with open(path, encoding="ascii") as file:
            text = file.read()
        for before, after in changes:
            if before not in text:
                foam.fail(f"{path}: no '{before}'")
            text = text.replace(before, after)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)
    x, r = mesh_points(surface, round(factor * ALONG), round(factor * OUTWARD), mach)
    write_mesh(os.path.join(folder, "constant/polyMesh"), x, r)
    return math.sin(SECTOR) / 2 * r[-1, 0] ** 2


def drag(folder, surface, mach, factor=1.0):
    """Time steps to the steady flow, each cell with its own."""
    base = prepare(folder, surface, mach, factor)
    last_step = 0
    for courant, steps in STAGES:
        last_step += round(factor * steps)
        with open(os.path.join(folder, "system/stream"), "w", encoding="ascii") as file:
            file.write(f"mach {mach!r};\ncourant {courant};\n")
        flow.steps(folder, last_step)
        foam.run(folder, "rhoCentralFoam")
    history = flow.coefficients(folder) * 0.5 / base  # the example's reference area is 0.5
    last, before = history[-MEAN:].mean(), history[-2 * MEAN:-MEAN].mean()
    if not abs(last - before) <= STEADY * abs(last):
        foam.fail(f"not steady after {last_step} steps: drag {before:.6g}, then {last:.6g}")
    return float(last)


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    mach = float(sys.argv[1])
    if len(sys.argv) == 3 or sys.argv[2].endswith(".obj"):
        factor = float(sys.argv[3]) if len(sys.argv) == 4 else 1.0
        print(f"{drag('nose_case', foam.read_obj(sys.argv[2]), mach, factor):.6f}")
        return
    with open(sys.argv[2], encoding="utf-8") as file:
        surface = foam.read_obj(json.load(file)["surface"])
    value = drag("case", surface, mach)
    with open(sys.argv[3], "w", encoding="ascii") as file:
        json.dump({"values": {"drag": value}}, file)
    flow.clean("case")


if __name__ == "__main__":
    main()
