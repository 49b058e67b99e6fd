#!/usr/bin/python3
"""Newton's body of least resistance, and the resistance of a written one: newton.py SURFACE.obj

J = integral of dA / (1 + |grad u|^2) over the disc below the body. The optimum is that among bodies of revolution whose radius grows
from the flat nose to the base. The surface has its axis along x, its nose in front and its vertices on rings.
"""
import json
import sys

import numpy as np

from obj import read_obj


def least(height):
    """J, radius and slope at the edge of the flat nose (I. Newton, 1687): with the slope p >= 1 and the radius c of the nose,
    r = c (1 + p^2)^2 / (4 p) and u = M - c (3 p^4 / 4 + p^2 - 7/4 - ln p) / 4."""
    def body(last):
        nose = 4 * last / (1 + last**2) ** 2
        return nose, nose / 4 * (0.75 * last**4 + last**2 - 1.75 - np.log(last))

    low, high = 1.0, 100.0
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if body(middle)[1] < height else (low, middle)
    nose = body(low)[0]
    p = np.linspace(1, low, 200001)
    r = nose * (1 + p**2) ** 2 / (4 * p)
    mean = 1 / (1 + ((p[1:] + p[:-1]) / 2) ** 2)
    return np.pi * (nose**2 + float(np.sum(mean * np.diff(r**2)))), nose, 1.0


def lower_bound(height, stations=500, slopes=1501, steepest=40.0):
    """The same J from below, without calculus of variations: for every multiplier the least of J + multiplier (drop - M) over all
    profiles that fall from the axis outward, station by station; the largest of these."""
    r = (np.arange(stations) + 0.5) / stations
    p = np.linspace(0, steepest**0.5, slopes) ** 2
    ring = 2 * np.pi * r[:, None] / (1 + p**2)

    def value(multiplier):
        return float(np.mean((ring + multiplier * p).min(1))) - multiplier * height

    low, high = 0.0, 10.0
    for _ in range(40):  # concave in the multiplier
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (a, high) if value(a) < value(b) else (low, b)
    return value((low + high) / 2)


def resistance(vertices, triangles):
    """Triangle by triangle: the windward ones, those that look ahead, along -x."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.cross(b - a, c - a) / 2
    if float(np.sum(np.cross(a, b) * c)) < 0:
        area = -area
    ahead = np.maximum(-area[:, 0], 0)
    return float(np.sum(ahead**3 / np.maximum(np.sum(area**2, 1), 1e-300))), float(np.sum(ahead))


def profile(vertices):
    """Places and radii of the rings on the windward side, nose first; the radius is that of the circle of the polygon's area."""
    radius = np.hypot(vertices[:, 1], vertices[:, 2])
    keys, first, count = np.unique(np.round(np.stack([vertices[:, 0], radius], 1), 9), axis=0, return_index=True, return_counts=True)
    around = int(count.max())
    rings = np.stack([vertices[first, 0], radius[first]], 1)[count == around]
    back = rings[:, 0].max()
    rings = rings[(rings[:, 0] < back - 1e-9) | (rings[:, 1] > rings[rings[:, 0] > back - 1e-9, 1].max() - 1e-9)]
    rings[:, 1] *= np.sqrt(around * np.sin(2 * np.pi / around) / (2 * np.pi))
    return rings[np.lexsort((rings[:, 1], rings[:, 0]))]


def judge(path):
    vertices, triangles = read_obj(path)
    value, disc = resistance(vertices, triangles)
    rings = profile(vertices)
    height = float(rings[-1, 0] - rings[0, 0])
    flat = rings[rings[:, 0] < rings[0, 0] + 1e-9, 1].max()
    side = rings[rings[:, 1] > flat - 1e-9]
    slope = np.diff(side[:, 0]) / np.diff(side[:, 1])
    revolved = np.pi * (flat**2 + float(np.sum(np.diff(side[:, 1] ** 2) / (1 + slope**2))))
    bends = np.diff(np.arctan(slope))
    best, nose, _ = least(height)
    return {"height": height, "disc": disc, "resistance": value, "revolved": revolved, "least": best, "nose": float(flat),
            "best_nose": nose, "slope_at_nose": float(slope[0]), "min_bend": float(bends.min())}


def main():
    print(json.dumps(judge(sys.argv[1])))


if __name__ == "__main__":
    main()
