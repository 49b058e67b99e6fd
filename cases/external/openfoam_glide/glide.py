#!/usr/bin/python3
"""Lift and drag of the lifting body at Mach 10 without friction, by OpenFOAM's rhoCentralFoam on half of the space: what the
Newtonian pressures of cases/lifting_body/glide.yaml are held against.

    glide.py FACTOR SURFACE:DEG..    coefficients of surfaces (OBJ, or STL in binary) at angles of attack in degrees, on meshes
                                     of FACTOR times the resolution, one line each

The coefficients are those of the whole body on the case's reference area of 30; the base has the pressure of the stream, which
in Newton's theory it has too. Flows go into generated/; one on a finer mesh begins from that at FACTOR 1, which has to be there.
"""
import math
import os
import shutil
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(HERE, "../openfoam"))
import flow
import foam

TEMPLATE = os.path.join(HERE, "foam")
CELLS = {"cellsAlong": 14, "cellsAcross": 7, "cellsHigh": 11}  # of the wind tunnel, before refinement
MACH = 10.0
BASE = 8.0       # where the body ends along x, and the stream with it
FIELDS = ["U", "p", "T"]
STEPS = 600, 600    # of first and of second order, at factor 1
NEAR = 300, 800     # the same on a finer mesh. Many more of the second order are no good: see docs/external/openfoam.md
COURANT = 0.2, 0.1  # in them; with 0.2, more cells of the leeward side become too cold in the second order
MEAN = 100       # steps that the coefficients are averaged over
STEADY = 1e-2    # largest difference between the means of the last steps and those before


def stream(folder, degrees):
    """The direction of the stream, for U and the coefficients."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    with open(os.path.join(folder, "system/stream"), "w", encoding="ascii") as file:
        file.write(f"mach {MACH!r};\nstream ({MACH * cosine!r} 0 {MACH * sine!r});\n"
                   f"along ({cosine!r} 0 {sine!r});\nupward ({-sine!r} 0 {cosine!r});\n")


def march(folder, steps, courant, limiter, of_vectors):
    with open(os.path.join(folder, "system/scheme"), "w", encoding="ascii") as file:
        file.write(f"courant {courant};\nlimiter {limiter};\nlimiterOfVectors {of_vectors};\n")
    flow.steps(folder, steps)
    foam.run(folder, "rhoCentralFoam")


def solve(folder, first, second):
    """Of first order until the stream has found its way around the body: before that, the second gives negative temperatures
    where the leeward side is nearly empty."""
    march(folder, first, COURANT[0], "upwind", "upwind")
    flow.start_from(folder, FIELDS)
    march(folder, second, COURANT[1], "Minmod", "MinmodV")
    values = {}
    for name, column in (("drag", "Cd"), ("lift", "Cl")):
        history = flow.coefficients(folder, column)
        last, before = history[-MEAN:].mean(), history[-2 * MEAN:-MEAN].mean()
        if not abs(last - before) <= STEADY * abs(last):
            foam.fail(f"{name} is not steady after {second} steps: {before:.6g}, then {last:.6g}")
        values[name] = float(last)
    return values


def read(file):
    """The surface, drawn out behind the base: so the mesher meets no edge where the stream ends."""
    vertices, triangles = foam.read_stl(file) if file.endswith(".stl") else foam.read_obj(file)
    vertices[vertices[:, 0] > BASE - 1e-3, 0] += 1
    return vertices, triangles


def body(file, degrees, factor, folder, near=None):
    """One flow; near: the folder of another one to begin from."""
    template = folder + "-template"
    shutil.rmtree(template, ignore_errors=True)
    shutil.copytree(TEMPLATE, template)
    stream(template, degrees)
    cells = flow.build(template, folder, read(file), flow.refined(CELLS, factor))
    shutil.rmtree(template)
    if near:
        flow.start_near(near, folder)
    values = solve(folder, *(NEAR if near else STEPS))
    flow.start_from(folder, FIELDS)
    return cells, values


def main(factor, names):
    os.makedirs("generated", exist_ok=True)
    for name in names:
        file, degrees = name.rsplit(":", 1)
        coarse = os.path.join("generated", f"flow-{os.path.basename(file)}-{degrees}")
        fine = f"{coarse}-by-{factor}"
        cells, values = body(file, float(degrees), factor, coarse if factor == "1" else fine,
                             os.path.abspath(coarse) if factor != "1" else None)
        print(f"{name}: {cells} cells, drag {values['drag']:.6f}, lift {values['lift']:.6f}, "
              f"lift to drag {values['lift'] / values['drag']:.4f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 3 or not all(":" in name for name in sys.argv[2:]):
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
