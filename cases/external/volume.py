#!/usr/bin/env python3
"""Enclosed volume of a closed surface, as an external program of Strake: copy this and put your own number in.

    command: [./volume.py, "{request}", "{result}"]
    format: obj

Strake runs it once an evaluation, in a fresh folder that holds the surface and request.json; it writes
result.json and, when Strake wants gradients, a CSV file with one row per vertex. docs/external.md tells the rest.
"""
import json
import sys


def read_obj(name):
    """Vertices [(x, y, z), ...] and triangles [(i, j, k), ...], counted from 0."""
    vertices, triangles = [], []
    with open(name) as lines:
        for line in lines:
            word = line.split()
            if word and word[0] == "v":
                vertices.append(tuple(float(x) for x in word[1:4]))
            elif word and word[0] == "f":
                triangles.append(tuple(int(corner.split("/")[0]) - 1 for corner in word[1:4]))
    return vertices, triangles


def minus(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def volume(vertices, triangles):
    """The volume, and how it changes when a vertex moves: one (dV/dx, dV/dy, dV/dz) per vertex."""
    value = 0.0
    gradient = [[0.0, 0.0, 0.0] for _ in vertices]
    for corners in triangles:
        a, b, c = (vertices[k] for k in corners)
        normal = cross(minus(b, a), minus(c, a))  # outward, twice the triangle's area
        value += dot(a, normal) / 6
        for k in corners:
            for axis in range(3):
                gradient[k][axis] += normal[axis] / 6
    return value, gradient


def main(request_file, result_file):
    with open(request_file) as file:
        request = json.load(file)
    value, gradient = volume(*read_obj(request["surface"]))
    result = {"value": value}
    if request["wanted"]["gradients"]:
        result["gradient"] = "gradient.csv"
        with open("gradient.csv", "w") as file:
            file.write("index,dJ/dx,dJ/dy,dJ/dz\n")
            for index, (x, y, z) in enumerate(gradient):
                file.write(f"{index},{x!r},{y!r},{z!r}\n")
    with open(result_file, "w") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
