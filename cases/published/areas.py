#!/usr/bin/python3
"""Wave drag of a written surface, by a way of its own: areas.py SURFACE.obj volume|diameter|base

Cuts the triangles by planes across x, sums the outlines to areas S, and expands S' in a sine series as von Karman did:
x = L (1 - cos t) / 2, S' = L sum A_n sin(n t), D/q = pi L^2 / 4 sum n A_n^2. (The quantity `wave_drag` integrates another way: areas
by the divergence theorem, the smoothest curve through equidistant stations.) Compares with the least drag at the body's own volume,
largest area or base and its length, and prints JSON: drags over the dynamic pressure, largest deviation of S over the largest S.
"""
import argparse
import json

import numpy as np

from obj import read_obj


def section_area(corners, x):
    """Area of the section at x: half the cross products of the segments, which run around it the same way."""
    above = corners[:, :, 0] >= x
    cut = corners[above.any(1) & ~above.all(1)]
    above = cut[:, :, 0] >= x
    ends = {}
    for side in (True, False):  # where the outline enters and leaves a triangle
        points = np.empty((len(cut), 2))
        for k in range(3):
            a, b = cut[:, k], cut[:, (k + 1) % 3]
            here = (above[:, k] == side) & (above[:, (k + 1) % 3] != side)
            t = (x - a[here, 0]) / (b[here, 0] - a[here, 0])
            points[here] = a[here, 1:] + t[:, None] * (b[here, 1:] - a[here, 1:])
        ends[side] = points
    p, q = ends[True], ends[False]
    return 0.5 * abs(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]))


def areas(vertices, triangles, stations, base=False):
    """Ends, angles t and areas at the stations, which are equidistant in t; ends included."""
    begin, end = vertices[:, 0].min(), vertices[:, 0].max()
    t = np.linspace(0, np.pi, stations + 2)
    x = begin + (end - begin) * (1 - np.cos(t)) / 2
    corners = vertices[triangles]
    S = np.array([0.0] + [section_area(corners, at) for at in x[1:-1]] + [0.0])
    if base:
        S[-1] = section_area(corners, end - 1e-9 * (end - begin))
    return begin, end, t, S


def wave_drag(t, S, length, harmonics):
    """D/q by the sine series; S' dx = dS makes the coefficients sums over the steps of S."""
    middle = (t[1:] + t[:-1]) / 2
    n = np.arange(1, harmonics + 1)[:, None]
    A = 4 / (np.pi * length**2) * (np.sin(n * middle) / np.sin(middle) @ np.diff(S))
    return np.pi * length**2 / 4 * float(np.sum(n[:, 0] * A**2))


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return abs(float(np.sum(np.cross(a, b) * c)) / 6)


def sears_haack(k, volume, length):
    """Areas of least drag at this volume and length, at k = x / length (W. R. Sears, 1947; W. Haack, 1941)."""
    return 16 * volume / (3 * np.pi * length) * (4 * k * (1 - k)) ** 1.5


def haack_diameter(k, largest):
    """Areas of least drag at this largest area and length, both ends pointed (W. Haack, 1941)."""
    y = np.abs(1 - 2 * k)
    with np.errstate(divide="ignore", invalid="ignore"):
        return largest * (np.sqrt(1 - y**2) - np.where(y > 0, y**2 * np.arccosh(1 / np.maximum(y, 1e-300)), 0))


def karman_ogive(k, base):
    """Areas of least drag at this base area and length (T. von Karman, 1935)."""
    t = np.arccos(1 - 2 * k)
    return base / np.pi * (t - np.sin(2 * t) / 2)


def judge(path, optimum, stations=2000, harmonics=200):
    """The surface against the optimum of its own volume, largest area or base: drag, least drag, deviation of S over largest S."""
    vertices, triangles = read_obj(path)
    base = optimum == "base"
    begin, end, t, S = areas(vertices, triangles, stations, base)
    length, k = end - begin, (1 - np.cos(t)) / 2
    if optimum == "volume":
        V = volume(vertices, triangles)
        least, best = 128 * V**2 / (np.pi * length**4), sears_haack(k, V, length)
    elif optimum == "diameter":
        middle = section_area(vertices[triangles], (begin + end) / 2)
        least, best = 4 * np.pi * middle**2 / length**2, haack_diameter(k, middle)
    else:
        least, best = 4 * S[-1] ** 2 / (np.pi * length**2), karman_ogive(k, S[-1])
    drag = wave_drag(t, S, length, harmonics)
    return {"drag": drag, "least": least, "excess": drag / least - 1,
            "area_error": float(np.max(np.abs(S - best)) / best.max()), "stations": stations, "harmonics": harmonics}


def oblique_areas(vertices, triangles, mach, roll, begin, end, stations):
    """Areas along the stream of cuts by planes at the Mach angle, at stations of the axis from begin to end: those of straight cuts
    after a shear."""
    sheared = vertices.copy()
    sheared[:, 0] -= np.sqrt(mach**2 - 1) * (vertices[:, 1] * np.cos(roll) + vertices[:, 2] * np.sin(roll))
    if sheared[:, 0].min() < begin - 1e-3 * (end - begin) or sheared[:, 0].max() > end + 1e-3 * (end - begin):  # of blunt tips
        raise ValueError("Mach cuts leave the length")
    x = begin + (end - begin) * (1 - np.cos(np.linspace(0, np.pi, stations + 2))) / 2
    corners = sheared[triangles]
    return np.array([0.0] + [section_area(corners, at) for at in x[1:-1]] + [0.0])


def judge_wing_body(body, wing, mach, stations=400, harmonics=150, rolls=16):
    """Wave drag of a body of revolution beside a wing that stays, by the area rule, and the least one of all such bodies of the same
    volume. S = S_f + S_w, and only S_w depends on the roll angle: the mean over it of a quadratic I is I[S_f + mean S_w] +
    mean I[S_w - mean S_w]. The second term is the wing's, the first one is at least Sears and Haack's for the volume of both."""
    body, wing = read_obj(body), read_obj(wing)
    begin, end = body[0][:, 0].min(), body[0][:, 0].max()
    t, length = np.linspace(0, np.pi, stations + 2), end - begin
    angles = [0.0] if mach == 1 else 2 * np.pi * np.arange(rolls) / rolls
    of_wing = np.array([oblique_areas(*wing, mach, roll, begin, end, stations) for roll in angles])
    of_body = np.array([oblique_areas(*body, mach, roll, begin, end, stations) for roll in angles])
    mean = of_wing.mean(0)
    total = volume(*body) + volume(*wing)
    drag = np.mean([wave_drag(t, S, length, harmonics) for S in of_wing + of_body])
    of_differences = np.mean([wave_drag(t, S - mean, length, harmonics) for S in of_wing])
    alone = wave_drag(t, sears_haack((1 - np.cos(t)) / 2, volume(*body), length) + mean, length, harmonics) + of_differences
    least = 128 * total**2 / (np.pi * length**4) + of_differences
    return {"drag": float(drag), "least": float(least), "share_of_wing": float(of_differences / least),
            "sears_haack_beside_wing": float(alone / least), "stations": stations, "rolls": len(angles)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("surface", help="OBJ file")
    parser.add_argument("optimum", choices=["volume", "diameter", "base"], help="what is given beside the length")
    parser.add_argument("--stations", type=int, default=2000)
    parser.add_argument("--harmonics", type=int, default=200)
    options = parser.parse_args()
    print(json.dumps(judge(options.surface, options.optimum, options.stations, options.harmonics)))


if __name__ == "__main__":
    main()
