"""The steps that the OpenFOAM examples have in common: a mesh about the start shape, made once, and then moved with the
surface for each evaluation. The moved mesh has the same cells, so equal surfaces give equal numbers, and values change
smoothly with the shape; a mesh built anew for each shape is a thousand times noisier.
"""
import glob
import os
import re
import shutil
import sys

import numpy as np

import foam
from carry import SurfaceMap


def steps(folder, last):
    """How many iterations or steps the next program may take; system/controlDict includes this file."""
    with open(os.path.join(folder, "system/lastStep"), "w", encoding="ascii") as file:
        file.write(f"lastStep {last};\n")


def build(template, folder, surface, sizes):
    """A new mesh about `surface` (vertices, triangles) in `folder`, a copy of the case `template` with system/meshSize
    made of `sizes`; returns its number of cells."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)
    os.makedirs(os.path.join(folder, "constant/triSurface"))
    foam.write_stl(os.path.join(folder, "constant/triSurface/body.stl"), *surface)
    with open(os.path.join(folder, "system/meshSize"), "w", encoding="ascii") as file:
        file.writelines(f"{name} {value};\n" for name, value in sizes.items())
    steps(folder, 1)
    foam.run(folder, "blockMesh")
    foam.run(folder, "snappyHexMesh", "-overwrite")
    return check(folder)


def check(folder):
    """The number of cells of a mesh that is good enough."""
    steps(folder, 1)
    told = foam.run(folder, "checkMesh", "-constant", "-noFunctionObjects")
    if "Mesh OK" not in told:
        foam.fail(f"the mesh about this shape is not good; see {folder}/log.checkMesh")
    return int(re.search(r"cells:\s+(\d+)", told)[1])


def start_from(folder, fields):
    """Makes the last fields the ones to start from, and removes all other times."""
    time = latest(folder)
    for name in fields:
        target = os.path.join(folder, "0", name)
        if os.path.islink(target):
            os.remove(target)  # it belongs to the base
        shutil.copyfile(os.path.join(folder, time, name), target)
    for name in os.listdir(folder):
        if re.fullmatch(r"[0-9.]+", name) and name != "0":
            shutil.rmtree(os.path.join(folder, name))


def latest(folder):
    """The name of the last time folder."""
    return max((name for name in os.listdir(folder) if re.fullmatch(r"[0-9.]+", name)), key=float)


def start_near(base, folder):
    """The fields to start from, interpolated from those of another mesh: sooner done than from the stream."""
    foam.run(folder, "mapFields", base, "-consistent", "-sourceTime", "0", "-mapMethod", "interpolate")


def save_map(folder, surface):
    """Ties the points of the patch `body` to the surface about which the mesh was built."""
    mesh = os.path.join(folder, "constant/polyMesh")
    points, faces = foam.read_points(mesh), foam.read_patch(mesh, "body")
    numbers = foam.points_of(faces)
    carried, worst = SurfaceMap.between(*surface, points[numbers])
    size = np.linalg.norm(np.ptp(surface[0], axis=0))
    if worst > 0.01 * size:
        foam.fail(f"a point of the mesh's boundary is {worst:.3g} from the surface; the mesher lost it")
    np.savez(os.path.join(folder, "map.npz"), vertices=surface[0], corners=carried.corners, weights=carried.weights,
             points=points[numbers], numbers=np.array(numbers))
    return worst / size


def read_map(folder):
    try:
        stored = np.load(os.path.join(folder, "map.npz"))
    except OSError:
        foam.fail(f"{folder}: no mesh yet; run prepare.sh of this folder first")
    return stored, SurfaceMap(stored["corners"], stored["weights"], len(stored["vertices"]))


def clone(base, folder):
    """A case that shares all large files with the base by links, except those that an evaluation changes."""
    os.makedirs(os.path.join(folder, "constant/polyMesh"))
    shutil.copytree(os.path.join(base, "system"), os.path.join(folder, "system"))
    for name in os.listdir(os.path.join(base, "constant")):
        if os.path.isfile(os.path.join(base, "constant", name)):
            shutil.copy(os.path.join(base, "constant", name), os.path.join(folder, "constant", name))
    for part in ("constant/polyMesh", "0"):
        os.makedirs(os.path.join(folder, part), exist_ok=True)
        for name in os.listdir(os.path.join(base, part)):
            source = os.path.realpath(os.path.join(base, part, name))
            if os.path.isfile(source):
                os.symlink(source, os.path.join(folder, part, name))


def displacement_field(at_body, outside):
    """0/pointDisplacement: given at the body; at the patches of `outside` zero ("fixed"), or along their planes (the type
    of the patch: "symmetry", "symmetryPlane")."""
    patches = [f"{name} {{ type fixedValue; value uniform (0 0 0); }}" if kind == "fixed" else f"{name} {{ type {kind}; }}"
               for name, kind in outside.items()]
    values = foam.vector_list(at_body)
    return (foam.header("pointVectorField", "pointDisplacement") +
            "dimensions [0 1 0 0 0 0 0];\ninternalField uniform (0 0 0);\nboundaryField\n{\n" + "\n".join(patches) +
            f"\nbody {{ type fixedValue; value nonuniform List<vector> {values}; }}\n}}\n")


def move(base, folder, vertices, outside):
    """The base's case in `folder` with its mesh moved to a surface of the same vertices; returns the SurfaceMap."""
    stored, carried = read_map(base)
    if len(vertices) != carried.num_vertices:
        foam.fail(f"the surface has {len(vertices)} vertices, the one that the mesh was made about "
                  f"{carried.num_vertices}; run prepare.sh again")
    shutil.rmtree(folder, ignore_errors=True)
    clone(base, folder)
    shift = carried.apply(vertices - stored["vertices"])
    if not shift.any():
        return carried
    field = os.path.join(folder, "0/pointDisplacement")
    with open(field, "w", encoding="ascii") as file:
        file.write(displacement_field(shift, outside))
    steps(folder, 1)
    foam.run(folder, "moveDynamicMesh", "-noFunctionObjects")
    points = os.path.join(folder, "constant/polyMesh/points")
    os.remove(points)
    os.replace(os.path.join(folder, "1/polyMesh/points"), points)
    shutil.rmtree(os.path.join(folder, "1"))
    os.remove(field)
    if "Mesh OK" not in foam.run(folder, "checkMesh", "-constant"):
        foam.fail(f"the mesh does not follow this shape; see {folder}/log.checkMesh")
    return carried


def coefficients(folder, name="Cd"):
    """A force coefficient at every step of the program that wrote one last."""
    files = glob.glob(os.path.join(folder, "postProcessing/forces/*/coefficient*.dat"))
    if not files:
        foam.fail(f"{folder}: no force coefficients")
    newest = max(files, key=os.path.getmtime)
    with open(newest, encoding="utf-8") as file:
        names = [line for line in file if line.startswith("#")][-1].lstrip("#").split()
    return foam.read_columns(newest)[:, names.index(name)]


def clean(folder):
    """Leaves the logs and the coefficients of an evaluation, removes meshes and fields."""
    for name in os.listdir(folder):
        path = os.path.join(folder, name)
        if os.path.isdir(path) and name != "postProcessing":
            shutil.rmtree(path)


def refined(cells, factor):
    """Numbers of background cells, FACTOR times as many along each direction."""
    return {name: round(float(factor) * value) for name, value in cells.items()}


def command_line(usage, prepare, rebuild, evaluate):
    """prepare SURFACE | rebuild FACTOR SURFACE.. | REQUEST RESULT"""
    if len(sys.argv) == 3 and sys.argv[1] == "prepare":
        prepare(sys.argv[2])
    elif len(sys.argv) >= 4 and sys.argv[1] == "rebuild":
        rebuild(sys.argv[2], sys.argv[3:])
    elif len(sys.argv) == 3:
        evaluate(sys.argv[1], sys.argv[2])
    else:
        sys.exit(usage)
