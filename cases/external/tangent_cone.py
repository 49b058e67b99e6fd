#!/usr/bin/env python3
"""Lift and drag at Mach 6 by the tangent-cone method, without gradients: stands in for a solver beside which Newton's
theory is the cheap model (low_fidelity.yaml).

    command: [./tangent_cone.py, "{request}", "{result}"]
    outputs: [drag, lift]
    format: obj
    gradients: false

Each triangle that meets the stream at the angle theta has the pressure of a cone of that half angle by hypersonic
similarity (Rasmussen), with K = MACH sin theta; the others have the free stream's. Values are forces over the dynamic
pressure: areas. At 4 degrees, positive nose up.
"""
import json
import math
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the case
from volume import cross, dot, minus, read_obj

MACH, GAMMA, ALPHA = 6.0, 1.4, math.radians(4)


def pressure(sine):
    """Coefficient of a cone at zero incidence."""
    if sine <= 0:
        return 0.0
    k = (MACH * sine) ** 2
    growth = ((GAMMA + 1) * k + 2) / ((GAMMA - 1) * k + 2)
    return sine * sine * (1 + growth * math.log((GAMMA + 1) / 2 + 1 / k))


def main(request_file, result_file):
    with open(request_file) as file:
        request = json.load(file)
    vertices, triangles = read_obj(request["surface"])
    stream, upward = (math.cos(ALPHA), 0.0, math.sin(ALPHA)), (-math.sin(ALPHA), 0.0, math.cos(ALPHA))
    drag = lift = 0.0
    for corners in triangles:
        a, b, c = (vertices[k] for k in corners)
        normal = cross(minus(b, a), minus(c, a))  # outward, twice the area
        size = math.sqrt(dot(normal, normal))
        if size > 0:
            force = pressure(-dot(stream, normal) / size)
            drag -= force * dot(stream, normal) / 2
            lift -= force * dot(upward, normal) / 2
    with open(result_file, "w") as file:
        json.dump({"values": {"drag": drag, "lift": lift}}, file)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
