#!/usr/bin/python3
"""Losses of total pressure in the S-bend of OpenFOAM's tutorials, laminar, with the gradient by OpenFOAM's adjoint solver.

    sbend.py REQUEST RESULT        an evaluation for Strake, in the current folder
    sbend.py prepare               the tutorial's mesh, its walls as a surface and the flow to start from, in generated/
    sbend.py losses SURFACE.obj    what the solver says of a duct with these walls

The mesh is the tutorial's own, of 24 000 cells; `strake apply` moves it with the walls, and takes the derivative by its points back to
theirs. Needs: scripts/setup.sh openfoam, the package openfoam-examples, and strake on PATH (or started by it).
"""
import gzip
import json
import os
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, "../external/openfoam"))
import domain  # noqa: E402
import flow  # noqa: E402
import foam  # noqa: E402
from mesh import Mesh  # noqa: E402

TUTORIALS = os.environ.get("FOAM_TUTORIALS", "/usr/share/doc/openfoam-examples/examples") + "/incompressible/adjointOptimisationFoam"
BASE = os.path.join(HERE, "generated/sbend")
POINTS = os.path.join(BASE, "points.npy")  # of the tutorial's mesh
WALLS, ENDS = ("upper", "lower", "sideWall"), ("Inlet", "Outlet")
VISCOSITY, INFLOW = 1.5e-5, (0.039473, 0, 0)
ITERATIONS = 3000
SOLVER = """
optimisationManager singleRun;
primalSolvers
{
    p1
    {
        active true; type incompressible; solver simple;
        solutionControls { nIters %(flow)d; residualControl { "p.*" 1e-7; "U.*" 1e-7; } }
    }
}
adjointManagers
{
    am1
    {
        primalSolver p1;
        adjointSolvers
        {
            as1
            {
                active %(adjoint)s; type incompressible; solver adjointSimple;
                computeSensitivities false;  // the script makes them of the fields
                objectives
                {
                    type incompressible;
                    objectiveNames { losses { weight 1; type PtLosses; patches (Inlet Outlet); } }
                }
                ATCModel { ATCModel standard; }
                solutionControls { nIters %(flow)d; residualControl { "pa.*" 1e-7; "Ua.*" 1e-7; } }
            }
        }
    }
}
"""
CONTROL = """
application adjointOptimisationFoam;
startFrom startTime; startTime 0; stopAt endTime; endTime %(last)d; deltaT 1;
writeControl timeStep; writeInterval %(last)d; writeFormat ascii; writePrecision 16; writeCompression off;
"""


def write(folder, name, text):
    with open(os.path.join(folder, name), "w", encoding="ascii") as file:
        file.write(foam.header("dictionary", os.path.basename(name)) + text)


def strake():
    """The program on PATH, or the one that has started this script."""
    found = os.environ.get("STRAKE") or shutil.which("strake")
    parent = os.path.realpath(f"/proc/{os.getppid()}/exe")
    if not found and os.path.basename(parent) == "strake":
        found = parent
    return found or foam.fail("strake is not on PATH")


def solve(folder):
    """Flow and adjoint; the losses."""
    write(folder, "system/optimisationDict", SOLVER % {"flow": ITERATIONS, "adjoint": "true"})
    write(folder, "system/controlDict", CONTROL % {"last": 2 * ITERATIONS})
    told = foam.run(folder, "adjointOptimisationFoam")
    if told.count("solution converged in") < 2:
        foam.fail(f"flow or adjoint have not converged in {ITERATIONS} iterations")
    return losses(folder)


def told_losses(folder):
    """The losses that the solver itself has printed last."""
    with open(os.path.join(folder, "log.adjointOptimisationFoam"), encoding="utf-8") as log:
        return float([line for line in log if line.startswith("losses :")][-1].split(":")[1])


def losses(folder):
    """- integral over inlet and outlet of (p + u^2 / 2) u . n, of the last fields."""
    where, fields, total = os.path.join(folder, "constant/polyMesh"), os.path.join(folder, flow.latest(folder)), 0.0
    mesh = Mesh.read(where)
    u, p = (foam.read_cell_field(os.path.join(fields, name), n) for name, n in (("U", 3), ("p", 1)))
    for name, speed, pressure in (("Inlet", INFLOW, None), ("Outlet", None, 0.0)):  # what is given there; else that of the cell
        faces = foam.patch_range(where, name)
        own = mesh.owner[faces]
        at = u[own] if speed is None else np.tile(speed, (len(faces), 1))
        head = (p[own, 0] if pressure is None else pressure) + 0.5 * np.sum(at * at, axis=1)
        total -= head @ np.sum(at * mesh.areas[faces], axis=1)
    return float(total)


def by_points(folder):
    """The derivative of the losses by all points of the mesh."""
    where = os.path.join(folder, "constant/polyMesh")
    mesh, fields = Mesh.read(where), os.path.join(folder, flow.latest(folder))
    read = lambda name, n: foam.read_cell_field(os.path.join(fields, name), n)
    walls = np.concatenate([foam.patch_range(where, name) for name in WALLS])
    g, _ = domain.by_points(mesh, (read("U", 3), read("p", 1)[:, 0]), (-read("Ua", 3), -read("pa", 1)[:, 0]), walls, 0, VISCOSITY)
    return g


def move(folder, surface):
    """The base's case with its mesh moved to the walls."""
    if not os.path.exists(POINTS):
        foam.fail(f"{BASE}: no mesh yet; run sbend.py prepare first")
    shutil.rmtree(folder, ignore_errors=True)
    flow.clone(BASE, folder)
    apply(surface, "moved.npy")
    mesh = os.path.join(folder, "constant/polyMesh")
    os.remove(os.path.join(mesh, "points"))
    foam.write_points(mesh, column_means(np.load(POINTS), np.load("moved.npy")))
    os.remove("moved.npy")
    volumes = Mesh.read(mesh).volumes
    if volumes.min() <= 0:
        foam.fail(f"{np.count_nonzero(volumes <= 0)} cells of the mesh turn inside out on these walls")


def apply(surface, out, *more):
    """`strake apply`: of the points of the tutorial's mesh, or back."""
    told = subprocess.run([strake(), "apply", os.path.join(HERE, "generated/sbend.obj"), POINTS, "--moved", surface, "-o", out, *more],
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if told.returncode != 0:
        foam.fail(told.stderr.strip() or told.stdout.strip())


def column_means(start, of_points):
    """In x and y, of the two points of each column of `start`: the mesh has one layer of cells, and its walls one diagonal to each face. The
    mean is its own transpose."""
    order = np.lexsort((start[:, 2], *np.round(start[:, :2].T, 9)))
    first, second = order[::2], order[1::2]
    if len(start) % 2 or not np.allclose(start[first, :2], start[second, :2], atol=1e-8):
        foam.fail("the mesh is not of one layer of cells")
    out = of_points.copy()
    out[first, :2] = out[second, :2] = 0.5 * (of_points[first, :2] + of_points[second, :2])
    return out


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    move("case", request["surface"])
    result = {"value": solve("case")}
    if request["wanted"]["gradients"]:
        np.save("by_points.npy", column_means(np.load(POINTS), by_points("case")))
        apply(request["surface"], "by_vertices.npy", "--sensitivities", "by_points.npy")
        with open("gradient.csv", "w", encoding="ascii") as file:
            for k, (x, y, z) in enumerate(np.load("by_vertices.npy").tolist()):
                file.write(f"{k},{x!r},{y!r},{z!r}\n")
        result["gradient"] = "gradient.csv"
    with open(result_file, "w", encoding="ascii") as file:
        json.dump(result, file)
    flow.clean("case")


def prepare():
    tutorial = os.path.join(TUTORIALS, "shapeOptimisation/sbend/laminar/opt/unconstrained/BFGS")
    if not os.path.isdir(tutorial):
        foam.fail(f"{tutorial}: not there; install openfoam-examples, or set FOAM_TUTORIALS")
    shutil.rmtree(BASE, ignore_errors=True)
    shutil.copytree(tutorial, BASE)
    os.remove(os.path.join(BASE, "constant/dynamicMeshDict"))
    mesh, packed = os.path.join(BASE, "constant/polyMesh"), os.path.join(TUTORIALS, "resources/meshes/sbend/polyMesh")
    os.makedirs(mesh)
    for name in os.listdir(packed):
        with gzip.open(os.path.join(packed, name)) as source, open(os.path.join(mesh, name.removesuffix(".gz")), "wb") as out:
            shutil.copyfileobj(source, out)
    np.save(POINTS, foam.read_points(mesh))
    write_walls(mesh, os.path.join(HERE, "generated/sbend.obj"))
    print(f"losses {solve(BASE):.6g}")
    flow.start_from(BASE, ["U", "p", "Ua", "pa"])


def write_walls(mesh, path):
    """Quadrilaterals of the boundary but for front and back, halved; each patch is a group."""
    points, rows = foam.read_points(mesh), {}
    with open(path, "w", encoding="ascii") as file:
        faces = {name: foam.read_patch(mesh, name) for name in WALLS + ENDS}
        for face in (f for name in faces for f in faces[name]):
            for k in face:
                if int(k) not in rows:
                    rows[int(k)] = len(rows) + 1
                    file.write("v %r %r %r\n" % tuple(float(x) for x in points[k]))
        for name in faces:
            file.write(f"g {name}\n")
            for a, b, c, d in faces[name]:
                file.write("f %d %d %d\nf %d %d %d\n" % tuple(rows[int(k)] for k in (a, b, c, a, c, d)))


if __name__ == "__main__":
    if sys.argv[1:] == ["prepare"]:
        prepare()
    elif len(sys.argv) == 3 and sys.argv[1] == "losses":
        move("moved", sys.argv[2])
        solve("moved")
        print(f"{told_losses('moved'):.8g}")
    elif len(sys.argv) == 3:
        evaluate(sys.argv[1], sys.argv[2])
    else:
        sys.exit(__doc__)
