#!/usr/bin/python3
"""The derivative by the shape that the drag example makes of the flow and its adjoint, without OpenFOAM:
openfoam_domain_test.py FOLDER_OF_THE_SCRIPTS"""
import os
import sys
import unittest

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.abspath(sys.argv.pop(1)))
import domain
from mesh import Mesh


def brick(counts, place=lambda x: x):
    """Hexahedra that fill the unit cube, points at place(x); also the numbers of the faces at x = 0."""
    n = np.array(counts)
    grid = np.stack(np.meshgrid(*(np.linspace(0, 1, k + 1) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
    point = lambda c: int((c[0] * (n[1] + 1) + c[1]) * (n[2] + 1) + c[2])
    cell = lambda c: int((c[0] * n[1] + c[1]) * n[2] + c[2])
    inner, outer = [], []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        for low in np.ndindex(*(n + np.eye(3, dtype=int)[axis])):
            c, e = np.array(low), np.eye(3, dtype=int)[axis]
            face = np.array([point(c), point(c + u), point(c + u + v), point(c + v)])  # points along +axis
            if c[axis] == 0:
                outer.append((axis != 0, face[::-1], cell(c)))
            elif c[axis] == n[axis]:
                outer.append((True, face, cell(c - e)))
            else:
                inner.append((cell(c - e), face, cell(c)))
    outer.sort(key=lambda row: row[0])
    faces = [row[1] for row in inner] + [row[1] for row in outer]
    owner = np.array([row[0] for row in inner] + [row[2] for row in outer])
    body = np.arange(len(inner), len(inner) + n[1] * n[2])
    return Mesh(place(grid), faces, owner, np.array([row[2] for row in inner])), body


def skewed(x):
    return x + 0.03 * np.sin(4 * x[:, [1, 2, 0]]) + 0.02 * x[:, [2, 0, 1]] * x


class Geometry(unittest.TestCase):
    def test_volumes_and_closed_cells(self):
        mesh, _ = brick((4, 3, 5))
        np.testing.assert_allclose(mesh.volumes, 1 / 60, rtol=1e-13)
        self.assertAlmostEqual(mesh.middles[0, 0], 0.125)
        mesh, _ = brick((4, 3, 5), skewed)
        total = mesh.over_cells(mesh.areas, -mesh.areas[:mesh.inner])
        np.testing.assert_allclose(total, 0, atol=1e-15)
        outside = np.einsum("ij,ij->", mesh.areas[mesh.inner:], mesh.centres[mesh.inner:]) / 3
        self.assertAlmostEqual(mesh.volumes.sum(), outside, delta=1e-4)  # faces are not quite plane

    def test_the_gradient_of_a_linear_field_is_exact_on_bricks(self):
        mesh, _ = brick((4, 5, 6))
        slope = np.array([[1.0, 2], [-3, 0.5], [0.25, 4]])
        at = mesh.gradient(mesh.middles @ slope, mesh.centres[mesh.inner:] @ slope)
        np.testing.assert_allclose(at, np.broadcast_to(slope, at.shape), atol=1e-12)


class Derivative(unittest.TestCase):
    def setUp(self):
        self.mesh, self.body = brick((6, 5, 4), skewed)
        random = np.random.default_rng(4)
        sizes = [(3,), (), (3,), ()]
        u, p, v, q = (random.normal(size=(self.mesh.cells,) + size) for size in sizes)
        self.fields, self.wall = ((u, p), (v, q)), random.normal(size=(len(self.body), 3))

    def force(self, mesh):
        by_points, value = domain.by_points(mesh, *self.fields, self.body, self.wall, 0.3)
        return by_points, value

    def test_an_affine_motion_of_all_points(self):
        """With the values in the cells held, gradients turn as under the map, but for the centres of faces that are not plane."""
        by_points, _ = self.force(self.mesh)
        matrix = np.random.default_rng(5).normal(size=(3, 3))
        step, shift = 1e-5, self.mesh.points @ matrix
        moved = [brick((6, 5, 4), lambda x, s=s: skewed(x) + s * step * skewed(x) @ matrix)[0] for s in (1, -1)]
        difference = (self.force(moved[0])[1] - self.force(moved[1])[1]) / (2 * step)
        self.assertAlmostEqual(np.sum(by_points * shift) / difference, 1, places=5)

    def test_a_shift_changes_nothing(self):
        by_points, _ = self.force(self.mesh)
        np.testing.assert_allclose(by_points.sum(axis=0), 0, atol=1e-11)


class Motion(unittest.TestCase):
    def test_the_transpose_is_that_of_a_motion_that_fades(self):
        """What one inner point gets of the body's points: weights between 0 and 1, less of them farther away."""
        mesh, body = brick((6, 4, 4))
        motion, shares = domain.Motion(mesh, body), []
        for x in (1, 2, 4):
            unit = np.zeros((len(mesh.points), 3))
            unit[(x * 5 + 2) * 5 + 2, 1] = 1
            got = motion.transpose(unit)
            self.assertTrue(np.all(got[:, [0, 2]] == 0) and np.all(got >= 0))
            self.assertLess(np.nonzero(got[:, 1])[0].max(), 25)  # points of the body
            shares.append(got[:, 1].sum())
        self.assertTrue(1 > shares[0] > shares[1] > shares[2] > 0, shares)
        on_body = np.zeros((len(mesh.points), 3))
        on_body[7] = 1, 2, 3
        np.testing.assert_array_equal(motion.transpose(on_body)[7], [1, 2, 3])

    def test_the_equation_is_solved(self):
        mesh, body = brick((8, 4, 4), skewed)
        motion, b = domain.Motion(mesh, body), np.zeros(mesh.cells)
        b[40] = 1
        np.testing.assert_allclose(motion.laplace(motion.solve(b)), b, atol=1e-7)


if __name__ == "__main__":
    unittest.main()
