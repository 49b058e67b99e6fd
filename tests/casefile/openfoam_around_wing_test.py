#!/usr/bin/python3
"""The mesh about a half wing, without OpenFOAM: openfoam_around_wing_test.py FOLDER_OF_THE_SCRIPTS"""
import os
import sys
import tempfile
import unittest

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.abspath(sys.argv.pop(1)))
import around_wing
import foam
from mesh import Mesh

SIZES = {"chord": 10, "wake": 4, "span": 6, "tip": 2, "outward": 8}


def wing():
    """A finer grid of the same wing, as vertices and triangles that share nothing along their seams."""
    fine = around_wing.Layout({"chord": 40, "wake": 1, "span": 30, "tip": 6, "outward": 1}, 1)
    rows = around_wing.mirrored(fine.upper()[0][:41])
    number = np.arange(rows.shape[0] * rows.shape[1]).reshape(rows.shape[:2])
    a, b, c, d = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return rows.reshape(-1, 3), triangles


class AroundWing(unittest.TestCase):
    def setUp(self):
        self.surface = wing()
        self.layout = around_wing.Layout(SIZES, 2e-3)
        self.carried, self.on_wing, self.distance = self.layout.wing(self.surface)
        self.points = self.layout.points(self.on_wing)

    def mesh(self, folder, points):
        around_wing.write_topology(folder, self.layout, points)
        foam.write_points(folder, points)
        return Mesh.read(folder)

    def check(self, points):
        with tempfile.TemporaryDirectory() as folder:
            mesh, body = self.mesh(folder, points), foam.patch_range(folder, "body")
            patches = [foam.patch_range(folder, name) for name in ("far", "symmetry", "body")]
        self.assertEqual(mesh.cells, 28 * 8 * 8)
        self.assertGreater(mesh.volumes.min(), 0)
        open_by = mesh.over_cells(mesh.areas, -mesh.areas[:mesh.inner])
        self.assertLess(np.abs(open_by).max(), 1e-12 * np.abs(mesh.areas).max())
        np.testing.assert_array_equal(np.concatenate(patches), np.arange(mesh.inner, len(mesh.owner)))
        self.assertEqual(len(body), 20 * 8)
        self.assertLess(np.abs(mesh.centres[patches[1], 1]).max(), 1e-12)
        away = np.einsum("ij,ij->i", mesh.areas, mesh.centres - mesh.middles[mesh.owner])
        self.assertGreater(away.min(), 0)  # normals leave the owner
        return mesh, body

    def test_cells_are_closed_and_fill_the_space_around_the_wing(self):
        mesh, body = self.check(self.points)
        inside = -np.einsum("ij,ij->", mesh.areas[body], mesh.centres[body]) / 3
        vertices, triangles = self.surface
        volume = np.einsum("ij,ij->", *(lambda c: (c[:, 0], np.cross(c[:, 1], c[:, 2])))(vertices[triangles])) / 6
        self.assertLess(abs(inside / abs(volume) - 1), 0.04)  # patch normals point into the body; few cells
        front = np.pi * around_wing.RADIUS ** 2 / 2 * around_wing.SPAN + np.pi * around_wing.RADIUS ** 3 / 3
        behind = (np.pi / 2 * around_wing.RADIUS ** 2 + 2 * around_wing.RADIUS * around_wing.SPAN) * (around_wing.OUTLET - 1)
        self.assertLess(abs(mesh.volumes.sum() / (front + behind) - 1), 0.1)

    def test_faces_stand_in_the_order_that_openfoam_wants(self):
        mesh, _ = self.check(self.points)
        owner = mesh.owner[:mesh.inner]
        self.assertTrue(np.all(owner < mesh.neighbour))
        self.assertTrue(np.all(np.diff(owner * mesh.cells + mesh.neighbour) > 0))

    def test_points_stand_on_the_surface_and_follow_it(self):
        self.assertLess(self.distance, 1e-3)
        vertices, _ = self.surface
        shift = 0.02 * vertices[:, 1:2] ** 2 * np.array([0.3, 0, 1]) * np.sin(3 * vertices[:, :1])
        moved = self.on_wing + self.carried.apply(shift)
        self.check(self.layout.points(moved))
        first = self.layout.points(self.on_wing + 1e-4 * self.carried.apply(shift)) - self.points
        all_of_it = self.layout.points(moved) - self.points
        self.assertGreater(np.abs(all_of_it).max(), 0.01)
        np.testing.assert_allclose(1e4 * first, all_of_it, atol=2e-3)
        np.testing.assert_array_equal(self.layout.points(self.on_wing), self.points)
        self.assertEqual(np.abs(all_of_it[np.abs(self.points[:, 1]) < 1e-12, 1]).max(), 0)  # the symmetry plane

    def test_twice_the_cells_meet_the_same_points_of_the_wing(self):
        fine = around_wing.Layout({name: 2 * n for name, n in SIZES.items()}, 1e-3)
        coarse = self.layout.upper()[0][:11]
        twice = fine.upper()[0][:21:2, ::2]
        np.testing.assert_allclose(twice[:, :7], coarse[:, :7], atol=1e-12)
        np.testing.assert_allclose(twice, coarse, atol=1e-12)


if __name__ == "__main__":
    unittest.main()
