"""A surface for the tests of the OpenFOAM examples."""
import numpy as np


def sphere(rings, around):
    """Vertices and outward triangles of a unit sphere, with poles on x."""
    angles = np.pi * np.arange(1, rings) / rings
    turns = 2 * np.pi * np.arange(around) / around
    middle = [(-np.cos(a), np.sin(a) * np.cos(b), np.sin(a) * np.sin(b)) for a in angles for b in turns]
    vertices = np.array([(-1, 0, 0), *middle, (1, 0, 0)], dtype=float)
    at = lambda ring, k: 1 + ring * around + k % around
    triangles = [(0, at(0, k + 1), at(0, k)) for k in range(around)]
    for ring in range(rings - 2):
        for k in range(around):
            triangles += [(at(ring, k), at(ring, k + 1), at(ring + 1, k)),
                          (at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k))]
    last = len(vertices) - 1
    triangles += [(last, at(rings - 2, k), at(rings - 2, k + 1)) for k in range(around)]
    return vertices, np.array(triangles)
