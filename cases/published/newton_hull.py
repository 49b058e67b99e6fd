#!/usr/bin/python3
"""Newton's body of least resistance without symmetry: the convex hull of the unit disc and of points above it.

    newton_hull.py HEIGHT prepare          the case with its variables, in generated/newton_hull_HEIGHT.yaml, and a surface that it names
    newton_hull.py REQUEST RESULT          an evaluation for Strake, in the current folder

Every such hull is a body that the problem admits, whatever the points: concave, over the disc, no higher than HEIGHT. The start has twelve
points on the edge of the flat nose of Newton's body and twelve on its side, each a little off its place, so that the symmetry may break; for
high bodies the nose is an ellipse of axes 9 : 4.
"""
import json
import math
import os
import sys

sys.dont_write_bytecode = True
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np  # noqa: E402
from scipy.spatial import ConvexHull  # noqa: E402

import surfaces  # noqa: E402
from newton import least  # noqa: E402

HERE = os.path.dirname(os.path.realpath(__file__))
POINTS, AROUND = 12, 720
CASE = """# Newton's problem, height {height:g}, without symmetry: the hull of the disc and of {count} points, whose places are the variables. Made by
# newton_hull.py; the surface is not used.
case: newton_hull
surface: {{file: newton_hull.obj}}
parameters: {{fields: none, variables: []}}
hold: point
quantities:
  air: {{command: [../newton_hull.py, "{{request}}", "{{result}}"], timeout: 5min}}
objective: {{minimize: air}}
optimize: {{method: sqp, budget: {{evaluations: 150}}}}
variables:
"""


def resistance(points, around=AROUND):
    """J of the hull of the points (n x 3) and the disc, and its derivative by the points. The disc is a polygon within it: J of the hull is no
    smaller than what is returned by more than 2 (pi / around)^2 / 3 of it."""
    t = 2 * np.pi * np.arange(around) / around
    vertices = np.vstack([points, np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)])
    hull = ConvexHull(vertices)
    faces = hull.simplices[hull.equations[:, 2] > 1e-12]
    a, b = (vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2))
    normal = np.cross(a, b)
    turn = np.sign(normal[:, 2])[:, None]
    normal *= turn
    square = np.sum(normal**2, axis=1)
    up = normal[:, 2]
    by_normal = -(up**3 / square**2)[:, None] * normal
    by_normal[:, 2] += 1.5 * up**2 / square
    by_normal *= turn
    by_a, by_b = np.cross(b, by_normal), np.cross(by_normal, a)
    gradient = np.zeros_like(vertices)
    for corner, part in ((1, by_a), (2, by_b), (0, -by_a - by_b)):
        np.add.at(gradient, faces[:, corner], part)
    return float(np.sum(up**3 / square)) / 2, gradient[:len(points)]


def polygon(height, corners, radius):
    turn = 2 * np.pi * np.arange(corners) / corners
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(corners, height)], axis=1)


def best_polygon(height, corners, around=2880):
    """The least J of the hulls of the disc and a regular polygon at the top, by golden sections."""
    low, high, share = 0.01, 0.99, (math.sqrt(5) - 1) / 2
    value = lambda radius: resistance(polygon(height, corners, radius), around)[0]
    for _ in range(22):
        a, b = high - share * (high - low), low + share * (high - low)
        low, high = (low, b) if value(a) < value(b) else (a, high)
    return value(0.5 * (low + high))


def start(height):
    """Points on Newton's body (newton.py)."""
    nose = least(height)[1]
    p = np.linspace(1, 100, 400001)
    r, u = nose * (1 + p**2) ** 2 / (4 * p), height - nose / 4 * (0.75 * p**4 + p**2 - 1.75 - np.log(p))
    side = 0.5 * (nose + 1)
    ring = polygon(np.interp(side, r, u), POINTS, side)
    turn = math.pi / POINTS
    ring[:, :2] = ring[:, :2] @ [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]
    points = np.vstack([polygon(height, POINTS, nose), ring])
    if height > 1.2:  # towards an edge at the top in place of a face
        points[:POINTS, :2] *= 1.5, 1 / 1.5
    points[:, :2] += 0.02 * np.random.default_rng(3).normal(size=(len(points), 2))
    return points


def points_of(variables):
    count = sum(name[0] == "x" for name in variables)
    return np.array([[variables[f"{axis}{k}"] for axis in "xyz"] for k in range(1, count + 1)])


def prepare(height):
    points = start(height)
    rows = []
    for k, (x, y, z) in enumerate(points.tolist(), 1):
        rows.append(f"  x{k}: {{start: {x:.6f}, min: -0.98, max: 0.98}}\n  y{k}: {{start: {y:.6f}, min: -0.98, max: 0.98}}\n"
                    f"  z{k}: {{start: {min(z, height):.6f}, min: 0, max: {height:g}}}\n")
    path = os.path.join(HERE, f"generated/newton_hull_{height:g}.yaml")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    surfaces.KINDS["frustum_1"](300).write(os.path.join(HERE, "generated/newton_hull.obj"))
    with open(path, "w", encoding="ascii") as file:
        file.write(CASE.format(height=height, count=len(points)) + "".join(rows))


def evaluate(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    value, gradient = resistance(points_of(request["variables"]))
    result = {"value": value}
    if request["wanted"]["gradients"]:
        with open("gradient.csv", "w", encoding="ascii") as file:
            file.writelines(f"{k},0,0,0\n" for k in range(request["vertices"]))
        result["gradient"] = "gradient.csv"
        result["variables"] = {f"{axis}{k + 1}": float(gradient[k, c]) for k in range(len(gradient)) for c, axis in enumerate("xyz")}
    with open(result_file, "w", encoding="ascii") as file:
        json.dump(result, file)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if sys.argv[2] == "prepare":
        prepare(float(sys.argv[1]))
    else:
        evaluate(*sys.argv[1:])
