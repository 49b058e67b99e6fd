#!/usr/bin/python3
"""Figures of the paper's examples, from surfaces before and after: paper_figures.py EXAMPLE START END...

    wing START SWEPT LIFTED       changes of sweep, dihedral and twist
    lifting_body START END        volume, held parts, the largest turn of a normal along the border of the held parts
    bunny START END               how far the ear turns, curvature of the face
    jet START END                 bad triangles before and after, creases
    triangle_near SURFACE X Y Z   number of the triangle nearest to a point
"""
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

import render


def read(path):
    """Vertices (n, 3) and triangles (m, 3); the corners of an STL are merged by their coordinates."""
    surface = render.read(path)
    points = vtk_to_numpy(surface.GetPoints().GetData()).astype(float)
    triangles = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return points, triangles


def corners(path):
    points, triangles = read(path)
    return points[triangles]


def volume(c):
    return np.einsum("ij,ij->i", c[:, 0], np.cross(c[:, 1], c[:, 2])).sum() / 6


def normals(c):
    n = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
    return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-300)


def stations(points, of, count=9):
    """Leading and trailing edge of sections of the start, followed to where their vertices move."""
    lines = []
    for y in np.linspace(0.1, 0.9, count) * points[:, 1].max():
        near = np.flatnonzero(np.abs(points[:, 1] - y) < 0.012 * points[:, 1].max())
        lines.append((of[near[points[near, 0].argmin()]], of[near[points[near, 0].argmax()]]))
    return np.array(lines)


def wing(start, swept, lifted):
    points, _ = read(start)

    def angles(of):
        edge = stations(points, of)
        middle = edge.mean(axis=1)
        chord = edge[:, 1] - edge[:, 0]
        sweep = np.degrees(np.arctan(np.polyfit(edge[:, 0, 1], edge[:, 0, 0], 1)[0]))
        dihedral = np.degrees(np.arctan(np.polyfit(middle[:, 1], middle[:, 2], 1)[0]))
        twist = np.degrees(np.arctan2(-chord[:, 2], chord[:, 0]))
        return sweep, dihedral, twist[-1] - twist[0]

    before = angles(points)
    for name, path in (("shear along the flow", swept), ("force across", lifted)):
        after = angles(read(path)[0])
        print(f"wing, {name}: " + ", ".join(f"{what} {b:+.2f} > {a:+.2f} deg"
                                            for what, b, a in zip(("sweep", "dihedral", "twist (nose up)"), before, after)))


def lifting_body(start, end):
    a, b = corners(start), corners(end)
    still = (a == b).all(axis=(1, 2))
    x = a[:, :, 0]
    held = (x.max(axis=1) <= 0.8) | (x.min(axis=1) >= 7.2)
    turn = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normals(a), normals(b)), -1, 1)))
    rim = ~held & ((np.abs(x - 0.8).min(axis=1) < 0.05) | (np.abs(x - 7.2).min(axis=1) < 0.05))
    print(f"lifting body: volume {volume(a):.4f} > {volume(b):.4f} ({100 * (volume(b) / volume(a) - 1):+.2f} %), "
          f"{held.sum()} held triangles, {(held & ~still).sum()} of them differ in any bit, "
          f"next to them normals turn by at most {turn[rim].max():.2f} deg, elsewhere by {turn.max():.1f}")


def mean_curvatures(points, triangles):
    """At the vertices: half of the length of the cotangent Laplacian, signed outward."""
    c = points[triangles]
    laplace, area, normal = np.zeros_like(points), np.zeros(len(points)), np.zeros_like(points)
    for k in range(3):
        i, j, o = triangles[:, k], triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3]
        u, v = points[i] - points[o], points[j] - points[o]
        cot = np.einsum("ij,ij->i", u, v) / np.linalg.norm(np.cross(u, v), axis=1)
        edge = (points[j] - points[i]) * (cot / 2)[:, None]
        np.add.at(laplace, i, edge)
        np.add.at(laplace, j, -edge)
    cross = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
    for k in range(3):
        np.add.at(area, triangles[:, k], np.linalg.norm(cross, axis=1) / 6)
        np.add.at(normal, triangles[:, k], cross)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return -np.einsum("ij,ij->i", laplace, normal) / (2 * area)


def bunny(start, end):
    (points, triangles), (moved, _) = read(start), read(end)
    before, after = mean_curvatures(points, triangles), mean_curvatures(moved, triangles)
    face = (points[:, 0] < -0.25) & (points[:, 1] > -0.05) & (points[:, 1] < 0.22) & (points[:, 2] > 0.05)
    change = np.sqrt(np.mean((after - before)[face] ** 2) / np.mean(before[face] ** 2))
    ear = (points[:, 0] < -0.2) & (points[:, 1] > 0.27) & (points[:, 2] < -0.2)
    a, b = points[ear] - points[ear].mean(axis=0), moved[ear] - moved[ear].mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = vt.T @ np.diag([1, 1, np.linalg.det(vt.T @ u.T)]) @ u.T
    angle = np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)))
    shift = np.linalg.norm(moved - points, axis=1).max() / np.linalg.norm(np.ptp(points, axis=0))
    print(f"bunny: the ear's tip turns by {angle:.1f} deg and moves by {100 * shift:.1f} % of the diagonal; mean curvature of "
          f"the face ({face.sum()} vertices) changes by {100 * change:.2f} % rms")


def qualities(c):
    a, b, d = (np.linalg.norm(c[:, (k + 1) % 3] - c[:, k], axis=1) for k in range(3))
    area = np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1) / 2
    s = (a + b + d) / 2
    return 8 * area**2 / np.maximum(s * a * b * d, 1e-300)  # 2 inradius / circumradius


def creases(points, triangles, limit=40):
    """Total length of the edges whose faces meet at more than `limit` degrees from flat."""
    n = normals(points[triangles])
    faces = {}
    for t, triangle in enumerate(triangles):
        for k in range(3):
            faces.setdefault(tuple(sorted((triangle[k], triangle[(k + 1) % 3]))), []).append(t)
    return sum(np.linalg.norm(points[i] - points[j]) for (i, j), two in faces.items()
               if len(two) == 2 and n[two[0]] @ n[two[1]] < np.cos(np.radians(limit)))


def jet(start, end):
    for name, path in (("before", start), ("after", end)):
        points, triangles = read(path)
        q = qualities(points[triangles])
        print(f"jet, {name}: {len(triangles)} triangles, quality mean {q.mean():.3f}, smallest {q.min():.2g}, below 0.2: "
              f"{(q < 0.2).sum()}, crease length {creases(points, triangles):.2f}, volume {volume(points[triangles]):.4f}")


def triangle_near(surface, *point):
    centre = corners(surface).mean(axis=1)
    print(np.linalg.norm(centre - np.array(point, float), axis=1).argmin())


EXAMPLES = {f.__name__: f for f in (wing, lifting_body, bunny, jet, triangle_near)}
if len(sys.argv) < 2 or sys.argv[1] not in EXAMPLES:
    sys.exit(__doc__)
EXAMPLES[sys.argv[1]](*sys.argv[2:])
