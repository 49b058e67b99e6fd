#!/usr/bin/env python3
"""Stands for SU2 where it is not installed: reads and writes the files that SU2 reads and writes, strictly, and has Newton's
impact theory in place of a flow.

    fake_su2.py SU2_DEF|SU2_CFD|SU2_CFD_AD|SU2_DOT_AD CONFIG   as the programs of these names
    fake_su2.py mesh SURFACE.obj FOLDER                        a mesh about the body: FOLDER/mesh.su2, surface.csv

The mesh has three shells of points, the body's and two around it, and prisms between them. Its points are numbered shell by
shell within each column, so that those of the body are not the first ones: as in any real mesh.
"""
import math
import os
import re
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the case
sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), ".."))
from newton import force
from played import mark_of, need, save, stop
from volume import cross, dot, minus, read_obj

SHELLS = (1.0, 1.6, 4.0)  # about the origin
OBJECTIVES = {"DRAG": "cd", "LIFT": "cl"}


def read_config(name):
    config = {}
    with open(name, encoding="ascii") as file:
        for number, line in enumerate(file, 1):
            line = line.partition("%")[0].strip()
            key, equals, value = line.partition("=")
            if not line:
                continue
            if not equals or key.strip() in config:
                stop(f"{name}, line {number}: '{line}' is no option, or stands twice")
            config[key.strip()] = value.strip()
    return config


def words(text):
    return text.strip("()").replace(",", " ").split()


class Mesh:
    """points: rows of three; cells: rows [type, corners..]; markers: {tag: rows [type, corners..]}."""

    def __init__(self, points, cells, markers):
        self.points, self.cells, self.markers = points, cells, markers

    @classmethod
    def read(cls, name):
        try:
            with open(name, encoding="ascii") as file:
                lines = [line for line in (row.partition("%")[0].strip() for row in file) if line]
        except OSError as error:
            stop(f"{name}: {error.strerror}")
        points, cells, markers, at = [], [], {}, 0

        def block(count, read):
            nonlocal at
            if at + count > len(lines):
                stop(f"{name}: ends within a list of {count}")
            rows = [read(line.split()) for line in lines[at:at + count]]
            at += count
            return rows

        while at < len(lines):
            key, _, value = (part.strip() for part in lines[at].partition("="))
            at += 1
            if key == "NDIME" and value != "3":
                stop(f"{name}: NDIME= {value}, expected 3")
            elif key == "NPOIN":
                points = block(int(value.split()[0]), lambda row: tuple(map(float, row[:3])))
            elif key == "NELEM":
                cells = block(int(value), lambda row: list(map(int, row[:7])))
            elif key == "MARKER_TAG":
                tag = value
            elif key == "MARKER_ELEMS":
                markers[tag] = block(int(value), lambda row: list(map(int, row[:4])))
        if any(k < 0 or k >= len(points) for row in cells + sum(markers.values(), []) for k in row[1:]):
            stop(f"{name}: a corner is not one of the {len(points)} points")
        return cls(points, cells, markers)

    def write(self, name):
        with open(name, "w", encoding="ascii") as file:
            file.write(f"NDIME= 3\nNELEM= {len(self.cells)}\n")
            file.writelines(" ".join(map(str, row)) + f" {k}\n" for k, row in enumerate(self.cells))
            file.write(f"NPOIN= {len(self.points)}\n")
            file.writelines("%r %r %r %d\n" % (*p, k) for k, p in enumerate(self.points))
            file.write(f"NMARK= {len(self.markers)}\n")
            for tag, rows in self.markers.items():
                file.write(f"MARKER_TAG= {tag}\nMARKER_ELEMS= {len(rows)}\n")
                file.writelines(" ".join(map(str, row)) + "\n" for row in rows)

    def shells(self, tag):
        """{point: (point of the marker below it, number of its shell)}, along the long edges of the prisms."""
        found = {k: (k, 0) for row in self.markers[tag] for k in row[1:]}
        for _ in SHELLS[1:]:
            for row in self.cells:
                for low, high in zip(row[1:4], row[4:7]):
                    if low in found and high not in found:
                        found[high] = (found[low][0], found[low][1] + 1)
        return found

    def closed_body(self, tag):
        """The triangles of a marker, seen to be closed and oriented."""
        triangles = [tuple(row[1:]) for row in self.markers[tag]]
        edges = {(t[k], t[k - 2]) for t in triangles for k in range(3)}
        if len(edges) != 3 * len(triangles) or any((b, a) not in edges for a, b in edges):
            stop(f"marker {tag} is not closed, or not oriented")
        return triangles


def deform(config):
    if config["DV_KIND"] != "SURFACE_FILE":
        stop(f"DV_KIND= {config['DV_KIND']}: only SURFACE_FILE is played here")
    mesh, (tag,) = Mesh.read(config["MESH_FILENAME"]), words(config["DV_MARKER"])
    below, moved = mesh.shells(tag), {}
    with open(config["DV_FILENAME"], encoding="ascii") as file:
        for number, line in enumerate(file, 1):
            row = line.split()
            if len(row) != 4 or not row[0].isdigit() or not all(math.isfinite(float(x)) for x in row[1:]):
                stop(f"{config['DV_FILENAME']}, line {number}: expected a point and its coordinates")
            if below.get(int(row[0]), (0, 1))[1] != 0 or int(row[0]) in moved:
                stop(f"{config['DV_FILENAME']}, line {number}: point {row[0]} is not on {tag}, or stands twice")
            moved[int(row[0])] = tuple(map(float, row[1:]))
    if len(moved) != sum(1 for _, shell in below.values() if shell == 0):
        stop(f"{config['DV_FILENAME']}: {len(moved)} points, {tag} has others")
    points = list(mesh.points)
    for k, (base, shell) in below.items():
        share = 1 - shell / (len(SHELLS) - 1)  # the outermost shell rests
        points[k] = moved[k] if shell == 0 else tuple(
            x + share * (new - old) for x, new, old in zip(mesh.points[k], moved[base], mesh.points[base]))
    folded = sum(1 for row in mesh.cells if prism_volume([points[k] for k in row[1:]]) <= 0)
    if folded:
        stop(f"{folded} cells have no positive volume")
    Mesh(points, mesh.cells, mesh.markers).write(config["MESH_OUT_FILENAME"])


def prism_volume(p):
    """Of a prism with corners (0, 1, 2) on the inner triangle, whose normal points away from (3, 4, 5)."""
    parts = ((0, 2, 1, 3), (1, 2, 4, 3), (2, 5, 4, 3))
    return sum(dot(cross(minus(p[b], p[a]), minus(p[c], p[a])), minus(p[d], p[a])) / 6 for a, b, c, d in parts)


def directions(config):
    alpha = math.radians(float(config["AOA"]))
    return {"DRAG": (math.cos(alpha), 0.0, math.sin(alpha)), "LIFT": (-math.sin(alpha), 0.0, math.cos(alpha))}


def coefficient(config, mesh, name):
    """The value, and its derivative by each point."""
    along, (tag,) = directions(config), words(config["MARKER_MONITORING"])
    value, gradient, _ = force(mesh.points, mesh.closed_body(tag), along["DRAG"], (0, 0, 0), along[name], (0, 0, 0))
    area = float(config["REF_AREA"])
    return value / area, [tuple(x / area for x in row) for row in gradient]


def needs_solution(name, config):
    """The files of solutions hold the mark of the mesh that they belong to."""
    need(name, mark_of(config["MESH_FILENAME"]), "another mesh")


def flow(config):
    mesh = Mesh.read(config["MESH_FILENAME"])
    given = words(config["MARKER_EULER"]) + words(config["MARKER_FAR"])
    if config["MATH_PROBLEM"] != "DIRECT" or sorted(given) != sorted(mesh.markers):
        stop(f"boundary conditions for {given}, the mesh has {sorted(mesh.markers)}")
    values = [coefficient(config, mesh, name)[0] for name in ("DRAG", "LIFT")]
    with open(config["CONV_FILENAME"] + ".csv", "w", encoding="ascii") as file:
        file.write('"Time_Iter","Outer_Iter","Inner_Iter",     "rms[Rho]"     ,       "CD"       ,       "CL"       \n')
        file.write(f"          0,           0,         499,  -1.0e+01, {values[0]!r}, {values[1]!r}\n")
    save(config["RESTART_FILENAME"] + ".dat", mark_of(config["MESH_FILENAME"]))


def adjoint(config):
    if config["MATH_PROBLEM"] != "DISCRETE_ADJOINT":
        stop("MATH_PROBLEM has to be DISCRETE_ADJOINT")
    needs_solution(config["SOLUTION_FILENAME"] + ".dat", config)
    save(f"{config['RESTART_ADJ_FILENAME']}_{OBJECTIVES[config['OBJECTIVE_FUNCTION']]}.dat", mark_of(config["MESH_FILENAME"]))


def project(config):
    needs_solution(f"{config['SOLUTION_ADJ_FILENAME']}_{OBJECTIVES[config['OBJECTIVE_FUNCTION']]}.dat", config)
    mesh, (tag,) = Mesh.read(config["MESH_FILENAME"]), words(config["DV_MARKER"])
    _, gradient = coefficient(config, mesh, config["OBJECTIVE_FUNCTION"])
    normals = [(0.0, 0.0, 0.0)] * len(mesh.points)
    for triangle in mesh.closed_body(tag):
        a, b, c = (mesh.points[k] for k in triangle)
        normal = cross(minus(b, a), minus(c, a))
        for k in triangle:
            normals[k] = tuple(x + y for x, y in zip(normals[k], normal))
    with open(config["SURFACE_SENS_FILENAME"] + ".csv", "w", encoding="ascii") as file:
        file.write('"PointID","x","y","z","Sensitivity_x","Sensitivity_y","Sensitivity_z","Surface_Sensitivity"\n')
        for k in sorted({k for row in mesh.markers[tag] for k in row[1:]}):
            across = -dot(gradient[k], normals[k]) / math.sqrt(dot(normals[k], normals[k]))
            file.write(", ".join([str(k), *map(repr, mesh.points[k]), *map(repr, gradient[k]), repr(across)]) + "\n")


def make_mesh(surface, folder):
    """The example's mesh, and the list of its surface points in the columns of SU2's surface files."""
    vertices, triangles = read_obj(surface)
    count = len(SHELLS)
    number = lambda vertex, shell: count * vertex + count - 1 - shell
    points = [tuple(f * x for x in v) for v in vertices for f in reversed(SHELLS)]
    cells = [[13, *(number(k, s + up) for up in (0, 1) for k in (a, c, b))] for a, b, c in triangles
             for s in range(count - 1)]
    markers = {"body": [[5, *(number(k, 0) for k in t)] for t in triangles],
               "far": [[5, *(number(k, count - 1) for k in t)] for t in triangles]}
    Mesh(points, cells, markers).write(os.path.join(folder, "mesh.su2"))
    with open(os.path.join(folder, "surface.csv"), "w", encoding="ascii") as file:
        file.write('"PointID","x","y","z"\n')
        rows = sorted((number(k, 0), v) for k, v in enumerate(vertices))
        file.writelines(", ".join([str(k), *map(repr, v)]) + "\n" for k, v in rows)


if __name__ == "__main__":
    programs = {"SU2_DEF": deform, "SU2_CFD": flow, "SU2_CFD_AD": adjoint, "SU2_DOT_AD": project}
    if len(sys.argv) == 4 and re.fullmatch("mesh", sys.argv[1]):
        make_mesh(*sys.argv[2:])
    elif len(sys.argv) == 3 and sys.argv[1] in programs:
        programs[sys.argv[1]](read_config(sys.argv[2]))
    else:
        sys.exit(__doc__)
