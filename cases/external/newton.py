#!/usr/bin/env python3
"""Lift and drag by Newton's impact theory, at an angle of attack that Strake chooses too.

    variables:  {alpha: {start: 4deg, min: 0deg, max: 10deg}}
    command: [./newton.py, "{request}", "{result}"]
    outputs: [drag, lift]
    format: obj

Shows two things that volume.py does not need: several values, and a variable that is not shape. The stream has the
direction u = (cos alpha, 0, sin alpha); where it meets the surface (u . n < 0, n outward) the pressure coefficient is
2 (u . n)^2, elsewhere 0. Values are forces over the dynamic pressure: areas.
"""
import json
import math
import sys

sys.dont_write_bytecode = True  # no __pycache__ beside the case
from volume import cross, dot, minus, read_obj


def times(factor, a):
    return factor * a[0], factor * a[1], factor * a[2]


def plus(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def force(vertices, triangles, u, du, direction, turned):
    """Force along `direction`, its derivative by each vertex, and that by alpha: du and turned are those of u and
    `direction`."""
    value = by_alpha = 0.0
    gradient = [(0.0, 0.0, 0.0)] * len(vertices)
    for corners in triangles:
        a, b, c = (vertices[k] for k in corners)
        area = times(0.5, cross(minus(b, a), minus(c, a)))  # outward
        meets = dot(u, area)
        size = dot(area, area)
        if meets >= 0 or size == 0:
            continue
        along, share = dot(direction, area), 2 * meets / size  # -Cp n A = -share * meets * area
        value -= share * meets * along
        by_alpha -= 2 * share * dot(du, area) * along + share * meets * dot(turned, area)
        by_area = plus(times(-2 * share * along, u), times(-share * meets, direction))
        by_area = plus(by_area, times(2 * share * meets * along / size, area))
        for k, edge in zip(corners, (minus(b, c), minus(c, a), minus(a, b))):
            gradient[k] = plus(gradient[k], times(0.5, cross(edge, by_area)))
    return value, gradient, by_alpha


def main(request_file, result_file):
    with open(request_file) as file:
        request = json.load(file)
    alpha = request["variables"]["alpha"]  # radians
    cosine, sine = math.cos(alpha), math.sin(alpha)
    stream, upward = (cosine, 0.0, sine), (-sine, 0.0, cosine)
    surface = read_obj(request["surface"])
    forces = {"drag": force(*surface, stream, upward, stream, upward),
              "lift": force(*surface, stream, upward, upward, times(-1, stream))}
    result = {"values": {name: forces[name][0] for name in forces}, "gradients": {}, "variables": {}}
    for name in request["wanted"]["gradients"]:
        result["gradients"][name] = name + ".csv"
        result["variables"][name] = {"alpha": forces[name][2]}
        with open(name + ".csv", "w") as file:
            for index, (x, y, z) in enumerate(forces[name][1]):
                file.write(f"{index},{x!r},{y!r},{z!r}\n")
    with open(result_file, "w") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
