#!/usr/bin/python3
"""The mesh about a slender body, without OpenFOAM: openfoam_around_test.py FOLDER_OF_THE_SCRIPTS"""
import contextlib
import io
import os
import sys
import tempfile
import unittest

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.abspath(sys.argv.pop(1)))
import around
import foam
from body_surface import sphere
from mesh import Mesh

SIZES = {"along": 20, "wake": 4, "around": 5, "outward": 8}


def spheroid(rings=120, turns=64):
    vertices, triangles = sphere(rings, turns)
    return vertices * [5, 0.5, 0.5] + [5, 0, 0], triangles


class Around(unittest.TestCase):
    def setUp(self):
        self.surface = spheroid()
        self.layout = around.Layout(SIZES, (0, 10), 0.8)
        self.points = self.layout.points(self.surface)

    def mesh(self, folder):
        around.write_topology(folder, self.layout, self.points)
        foam.write_points(folder, self.points)
        return Mesh.read(folder)

    def test_cells_are_closed_and_fill_the_space_around_the_body(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh, body = self.mesh(folder), foam.patch_range(folder, "body")
            patches = [foam.patch_range(folder, name) for name in ("inlet", "outlet", "symmetry", "body")]
        self.assertEqual(mesh.cells, 24 * 5 * 8)
        self.assertGreater(mesh.volumes.min(), 0)
        open_by = mesh.over_cells(mesh.areas, -mesh.areas[:mesh.inner])
        self.assertLess(np.abs(open_by).max(), 1e-12 * np.abs(mesh.areas).max())
        np.testing.assert_array_equal(np.concatenate(patches), np.arange(mesh.inner, len(mesh.owner)))
        self.assertEqual(len(body), 20 * 5)
        inside = -np.einsum("ij,ij->", mesh.areas[body], mesh.centres[body]) / 3
        self.assertLess(abs(inside / (2 / 3 * np.pi * 5 * 0.25) - 1), 0.01)  # patch normals point into the body

    def test_faces_stand_in_the_order_that_openfoam_wants(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh = self.mesh(folder)
        inner, owner = mesh.inner, mesh.owner
        self.assertTrue(np.all(owner[:inner] < mesh.neighbour))
        keys = owner[:inner] * mesh.cells + mesh.neighbour
        self.assertTrue(np.all(np.diff(keys) > 0))
        # Normals leave the owner.
        away = np.einsum("ij,ij->i", mesh.areas, mesh.centres - mesh.middles[owner])
        self.assertGreater(away.min(), 0)

    def test_radii_are_those_of_the_surface(self):
        vertices, triangles = self.surface
        angle = np.linspace(0, np.pi, 6)
        across = np.stack([0 * angle, np.sin(angle), -np.cos(angle)], axis=1)
        x = np.array([0.3, 2, 5, 8.5])
        found = around.radii(vertices, triangles, x, across)
        exact = 0.5 * np.sqrt(1 - ((x - 5) / 5) ** 2)
        np.testing.assert_allclose(found, np.repeat(exact[:, None], 6, axis=1), rtol=3e-3)

    def test_points_follow_the_surface_smoothly(self):
        vertices, triangles = self.surface
        bump = np.exp(-((vertices[:, :1] - 4) / 1.5) ** 2) * vertices * [0, 1, 1]
        move = lambda step: self.layout.points((vertices + step * bump, triangles))
        first, second = (move(1e-4) - move(-1e-4)) / 2e-4, (move(1e-2) - move(-1e-2)) / 2e-2
        self.assertGreater(np.abs(first).max(), 0.4)
        np.testing.assert_allclose(first, second, atol=2e-3)
        np.testing.assert_array_equal(move(0), self.points)

    def test_twice_the_cells_meet_the_same_stations(self):
        fine = around.Layout({name: 2 * n for name, n in SIZES.items()}, (0, 10), 0.8)
        np.testing.assert_allclose(fine.stations()[::2], self.layout.stations(), atol=1e-12)
        self.assertLess(np.diff(fine.stations()).max(), 0.6 * np.diff(self.layout.stations()).max())

    def test_a_body_that_is_not_visible_from_its_axis_ends_the_evaluation(self):
        vertices, triangles = self.surface
        told = io.StringIO()
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(told):
            self.layout.points((vertices + [0, 0, 0.6], triangles))
        self.assertIn("not visible from the axis", told.getvalue())

    def test_steps_grow_evenly_from_the_first(self):
        steps = np.diff(around.graded(np.array([0.02, 0.125, 0.2]), 8), axis=1)
        np.testing.assert_allclose(steps[:, 0], [0.02, 0.125, 0.2], rtol=1e-6)
        np.testing.assert_allclose(steps.sum(axis=1), 1, rtol=1e-12)
        np.testing.assert_allclose(steps[:, 1:] / steps[:, :-1], np.repeat(steps[:, 1:2] / steps[:, :1], 7, axis=1), rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
