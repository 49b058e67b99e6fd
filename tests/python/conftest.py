"""Surfaces to test with, made here: nothing is read from outside."""
import os
import pathlib
import sys

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python/examples"))

import strake  # noqa: E402  (on the path that ctest gives)


def ellipsoid(axes=(1.0, 0.6, 0.4), n=16):
    """Triangles between circles of latitude, poles at both ends of x."""
    rings = [[-axes[0], 0, 0]]
    for i in range(1, n):
        a = np.pi * i / n
        for j in range(2 * n):
            b = np.pi * (j + 0.5 * (i % 2)) / n
            rings.append([-axes[0] * np.cos(a), axes[1] * np.sin(a) * np.cos(b), axes[2] * np.sin(a) * np.sin(b)])
    rings.append([axes[0], 0, 0])
    m, triangles = 2 * n, []
    at = lambda i, j: 1 + (i - 1) * m + j % m
    for j in range(m):
        triangles.append([0, at(1, j + 1), at(1, j)])
        triangles.append([len(rings) - 1, at(n - 1, j), at(n - 1, j + 1)])
    for i in range(1, n - 1):
        for j in range(m):
            if i % 2:
                triangles += [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]]
            else:
                triangles += [[at(i, j), at(i + 1, j + 1), at(i + 1, j)], [at(i, j), at(i, j + 1), at(i + 1, j + 1)]]
    surface = strake.Surface(np.array(rings), np.array(triangles, dtype=np.int32))
    if surface.volume < 0:
        surface = strake.Surface(surface.vertices, surface.triangles[:, ::-1].copy())
    return surface


@pytest.fixture(scope="session")
def body():
    return ellipsoid(n=10)


@pytest.fixture(scope="session")
def program():
    path = os.environ.get("STRAKE_PROGRAM")
    if not path:
        pytest.skip("STRAKE_PROGRAM names no program: ctest sets it")
    return path


def nose(surface):
    """Triangles with all corners at x < -0.6."""
    return np.nonzero((surface.vertices[surface.triangles][:, :, 0] < -0.6).all(axis=1))[0]
