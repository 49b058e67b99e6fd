#!/usr/bin/python3
"""A wing in a Bezier box: box.py REQUEST RESULT

Evaluates what is wanted: drag and lift as wing.py, or the volume of the half wing with its slopes. `variables.pIJK` of the request,
in [-1, 1], move a point of the box up and down by up to REACH: I = 0..3 along the chord, J = 1..3 along the span (those at the
root, J = 0, do not move), K = 0, 1 below and above. The box follows the planform of make_surface wing, and moves all of it."""
import json
import math
import sys

import numpy as np
import twist
import wing

import foam  # in the folder that wing.py adds to the path

REACH = 0.05    # m, about the thickness of the root
HEIGHT = 0.12   # m, above and below the plane of the wing: the twisted tip is inside


def bernstein(n, at):
    return np.stack([math.comb(n, k) * at**k * (1 - at) ** (n - k) for k in range(n + 1)], axis=1)


def weights(points):
    """n x 4 x 4 x 2: what each point of the box moves at x."""
    x, y, z = points.T
    chord = twist.ROOT * (1 + y / twist.SPAN * (twist.TAPER - 1))
    edge = y * twist.SWEEP + 0.25 * (twist.ROOT - chord)
    along = [np.clip(t, 0, 1) for t in ((x - edge) / chord, y / twist.SPAN, 0.5 + 0.5 * z / HEIGHT)]
    chordwise, spanwise, upward = bernstein(3, along[0]), bernstein(3, along[1]), bernstein(1, along[2])
    return np.einsum("ni,nj,nk->nijk", chordwise, spanwise, upward)


def volume(points, triangles):
    """Of the half that the plane y = 0 closes, and its slope by every place."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    slope = np.zeros_like(points)
    for k, (p, q) in enumerate(((b, c), (c, a), (a, b))):
        np.add.at(slope, triangles[:, k], np.cross(p, q) / 6)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6), slope


def main(request_file, result_file):
    with open(request_file, encoding="utf-8") as file:
        request = json.load(file)
    points, triangles = foam.read_obj(request["surface"])[:2]
    values = {name: x for name, x in request["variables"].items() if name.startswith("p")}
    weight = weights(points)
    by = {name: REACH * weight[:, int(name[1]), int(name[2]), int(name[3])] for name in values}
    points[:, 2] += sum(x * by[name] for name, x in values.items())
    if "volume" not in request["wanted"]["values"]:
        wing.evaluate_surface(points, request["variables"]["alpha"], result_file)
        return
    value, slope = volume(points, triangles)
    np.savetxt("volume.csv", slope, delimiter=",")
    with open(result_file, "w", encoding="ascii") as file:
        json.dump({"values": {"volume": value}, "gradients": {"volume": "volume.csv"},
                   "variables": {"volume": {"alpha": 0.0, **{name: float(slope[:, 2] @ by[name]) for name in values}}}}, file)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
