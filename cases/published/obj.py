"""Surfaces as Strake writes them, for the solvers and judges of the published problems."""
import numpy as np


def read_obj(path):
    """Vertices (n x 3) and triangles (m x 3, from 0) of an OBJ file that has nothing but triangles."""
    vertices, triangles = [], []
    with open(path, encoding="ascii") as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                triangles.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(vertices), np.array(triangles)
