"""What the OpenFOAM examples share: runs OpenFOAM's programs, reads and writes its files (ASCII, as version 1912 of
Debian 12 writes them).
"""
import ctypes
import os
import re
import signal
import subprocess
import sys

import numpy as np

PROJECT = "/usr/share/openfoam"  # without WM_PROJECT_DIR every program aborts: it does not find etc/controlDict
NUMBER = rb"[-+0-9.eE]+"


def fail(message):
    """Ends the evaluation: Strake reads the status, and its message shows this line."""
    print(f"{os.path.basename(sys.argv[0])}: {message}", file=sys.stderr)
    sys.exit(1)


def end_with_parent():
    """Linux: the program is killed when the script dies, so that a killed run leaves no solver behind."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def run(folder, *command):
    """Runs a program in `folder` with its output in log.<program>; returns the output."""
    log = os.path.join(folder, "log." + command[0])
    environment = dict(os.environ, WM_PROJECT_DIR=os.environ.get("WM_PROJECT_DIR", PROJECT))
    try:
        with open(log, "wb") as file:
            status = subprocess.run(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=file,
                                    stderr=subprocess.STDOUT, check=False, preexec_fn=end_with_parent).returncode
    except FileNotFoundError:
        fail(f"{command[0]}: not found; install OpenFOAM: scripts/setup.sh openfoam")
    with open(log, encoding="utf-8", errors="replace") as file:
        text = file.read()
    if status != 0 or "FOAM FATAL" in text:
        print("\n".join(text.splitlines()[-15:]), file=sys.stderr)
        fail(f"{command[0]} ended with status {status}; see {log}")
    return text


def header(kind, name):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def vector_list(values):
    """A List<vector> with all digits, so that equal shapes give equal bits."""
    rows = "\n".join("(%r %r %r)" % (float(x), float(y), float(z)) for x, y, z in values)
    return f"{len(values)}\n(\n{rows}\n)\n"


def body_of(path):
    """The file without its header, comments removed."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        fail(f"{path}: {error.strerror}")
    data = re.sub(rb"/\*.*?\*/|//[^\n]*", b"", data, flags=re.DOTALL)
    return re.sub(rb"FoamFile\s*\{.*?\}", b"", data, count=1, flags=re.DOTALL)


def numbers(data):
    return np.array(re.findall(NUMBER, data), dtype=float)


def read_points(mesh):
    """Points of a polyMesh folder, n x 3."""
    values = numbers(body_of(os.path.join(mesh, "points")))
    if values.size != 1 + 3 * int(values[0]):
        fail(f"{mesh}/points: {values.size} numbers, expected 1 + 3 x {int(values[0])}")
    return values[1:].reshape(-1, 3)


def write_points(mesh, points):
    os.makedirs(mesh, exist_ok=True)
    with open(os.path.join(mesh, "points"), "w", encoding="ascii") as file:
        file.write(header("vectorField", "points") + vector_list(points))


def patch_range(mesh, name):
    """Numbers of the faces of a boundary patch."""
    boundary = body_of(os.path.join(mesh, "boundary")).decode()
    found = re.search(rf"\b{name}\s*\{{(.*?)\}}", boundary, re.DOTALL)
    if not found:
        fail(f"{mesh}/boundary: no patch '{name}'")
    start, count = (int(re.search(rf"{key}\s+(\d+)", found[1])[1]) for key in ("startFace", "nFaces"))
    return np.arange(start, start + count)


def read_patch(mesh, name):
    """Faces of a boundary patch: a list of arrays of point numbers; normals point out of the fluid."""
    rows = patch_range(mesh, name)
    all_faces = re.findall(rb"\d+\(([^)]*)\)", body_of(os.path.join(mesh, "faces")))
    faces = all_faces[rows[0]:rows[-1] + 1] if len(rows) else []
    if len(faces) != len(rows) or not faces:
        fail(f"{mesh}/faces: {len(faces)} faces of patch '{name}', expected {len(rows)} > 0")
    return [np.array(face.split(), dtype=int) for face in faces]


def points_of(faces):
    """Numbers of the points of a patch in OpenFOAM's order: as they appear when one walks the faces."""
    return list(dict.fromkeys(int(k) for face in faces for k in face))


def read_list(path, text, what, components):
    """Values of the first nonuniform list in `text`, a part of the file `path`, rows x components."""
    found = text and re.search(rb"nonuniform\s+List<\w+>\s*(\d+)\s*\((.*?)\)\s*;", text, re.DOTALL)
    if not found:
        fail(f"{path}: no nonuniform values {what}")
    values = numbers(found[2])
    if values.size != int(found[1]) * components:
        fail(f"{path}: {values.size} numbers {what}, expected {int(found[1])} x {components}")
    if not np.all(np.isfinite(values)):
        fail(f"{path}: not finite {what}")
    return values.reshape(-1, components)


def read_cell_field(path, components):
    """Values in the cells of a volume field, cells x components."""
    return read_list(path, body_of(path).partition(b"boundaryField")[0], "in the cells", components)


def read_patch_field(path, name, components):
    """Values on a patch of a volume field, faces x components."""
    found = re.search(rb"\b" + name.encode() + rb"\s*\{(.*?)\n\s*\}", body_of(path).partition(b"boundaryField")[2], re.DOTALL)
    return read_list(path, found and found[1], f"on patch '{name}'", components)


def read_columns(path):
    """A table of a function object: rows of numbers, comments left out."""
    try:
        table = np.loadtxt(path, comments="#", ndmin=2)
    except (OSError, ValueError) as error:
        fail(f"{path}: {error}")
    if table.size == 0 or not np.all(np.isfinite(table)):
        fail(f"{path}: empty, or not finite")
    return table


def read_obj(path):
    """Vertices (n x 3) and triangles (m x 3, from 0) of a surface as Strake writes it."""
    vertices, triangles = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words and words[0] == "v":
                vertices.append([float(w) for w in words[1:4]])
            elif words and words[0] == "f":
                triangles.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(vertices), np.array(triangles)


STL_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])


def read_stl(path):
    """Corners (3m x 3) and triangles (m x 3) of a binary STL: corners that coincide are not joined."""
    with open(path, "rb") as file:
        data = file.read()
    count = int(np.frombuffer(data[80:84].ljust(4, b"\0"), "<u4")[0])
    if len(data) != 84 + count * STL_RECORD.itemsize:
        fail(f"{path}: {len(data)} bytes; a binary STL of {count} triangles has {84 + count * STL_RECORD.itemsize}")
    corners = np.frombuffer(data, STL_RECORD, offset=84)["corners"].reshape(-1, 3).astype(float)
    return corners, np.arange(3 * count).reshape(-1, 3)


def write_stl(path, vertices, triangles):
    """Binary STL, in single precision as the format demands."""
    record = np.zeros(len(triangles), dtype=STL_RECORD)
    record["corners"] = vertices[triangles]
    with open(path, "wb") as file:
        file.write(b"body".ljust(80) + np.uint32(len(triangles)).tobytes() + record.tobytes())
