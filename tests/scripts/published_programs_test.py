#!/usr/bin/python3
"""The programs of cases/published by themselves: closed forms, and derivatives of order 2. Argument: the repository."""
import math
import os
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

try:
    import numpy as np
    import scipy  # noqa: F401
except ImportError:
    print("skipped: needs python3-numpy and python3-scipy")
    sys.exit(77)

ROOT = sys.argv.pop(1)
sys.path[:0] = [f"{ROOT}/{folder}" for folder in ("cases/published", "cases/published/transonic", "scripts")]
import areas  # noqa: E402
import cone  # noqa: E402
import lattice  # noqa: E402
import m6  # noqa: E402
import newton  # noqa: E402
import newton_hull  # noqa: E402
import nose  # noqa: E402
import published  # noqa: E402
import published_levels  # noqa: E402
import sbend  # noqa: E402
import stokes  # noqa: E402
import surfaces  # noqa: E402
import trefftz  # noqa: E402
import foam  # noqa: E402  (nose adds its folder)
from mesh import Mesh  # noqa: E402


def arrays(surface):
    return np.array(surface.vertices), np.array(surface.triangles)


def order(value, slope, step):
    """Of the remainder value(h) - value(0) - h slope, between step and a quarter of it."""
    rest = [abs(value(h) - value(0) - h * slope) for h in (step, step / 4)]
    return math.log(rest[0] / rest[1]) / math.log(4)


class MinWaveDrag(unittest.TestCase):
    """The published optima are those of a quadratic program in the coefficients of S' = L sum A_n sin(n t), L = 1: least
    pi / 4 sum n A_n^2 under one linear condition, which is integrated here."""

    def least(self, condition, sums=(), count=400):
        n = np.arange(1, count + 1)
        t = np.linspace(0, np.pi, 40001)
        x, slope = (1 - np.cos(t)) / 2, np.sin(t) / 2
        areas_of = np.array([np.concatenate([[0], np.cumsum((f[1:] + f[:-1]) / 2 * np.diff(t))])
                             for f in np.sin(np.outer(n, t)) * slope])
        rows = np.array([g(areas_of, x) for g in (condition, *sums)])
        # min a.W a, rows a = wanted: wanted . (rows W^-1 rows^T)^-1 wanted
        return np.linalg.inv((rows / (np.pi / 4 * n)) @ rows.T)[0, 0]

    def test_volume(self):
        closed = lambda S, x: S[:, -1]
        volume = lambda S, x: np.sum((S[:, 1:] + S[:, :-1]) / 2 * np.diff(x), 1)
        self.assertAlmostEqual(self.least(volume, (closed,)) / (128 / np.pi), 1, delta=1e-6)

    def test_largest_area(self):
        closed = lambda S, x: S[:, -1]
        middle = lambda S, x: S[:, S.shape[1] // 2]
        self.assertAlmostEqual(self.least(middle, (closed,)) / (4 * np.pi), 1, delta=1e-4)  # 400 sines of a kink
        beside = lambda S, x: S[:, int(0.45 * S.shape[1])]
        self.assertGreater(self.least(beside, (closed,)) / (4 * np.pi), 1.001)

    def test_base(self):
        self.assertAlmostEqual(self.least(lambda S, x: S[:, -1]) / (4 / np.pi), 1, delta=1e-6)

    def test_judge(self):
        t = np.linspace(0, np.pi, 2002)
        k = (1 - np.cos(t)) / 2
        for S, least in ((areas.sears_haack(k, 1, 1), 128 / np.pi), (areas.haack_diameter(k, 1), 4 * np.pi),
                         (areas.karman_ogive(k, 1), 4 / np.pi)):
            self.assertAlmostEqual(areas.wave_drag(t, S, 1, 200) / least, 1, delta=1e-4)
            bumped = S * (1 + 0.1 * np.sin(6 * np.pi * k) * np.sin(np.pi * k))
            self.assertGreater(areas.wave_drag(t, bumped, 1, 200) / least, 1.05)

    def test_sections(self):
        vertices, triangles = arrays(surfaces.KINDS["cylinder_with_cones"](4000))
        around = int(np.sum(abs(vertices[:, 0] - vertices[1, 0]) < 1e-12))
        polygon = around / 2 * math.sin(2 * math.pi / around) * surfaces.RADIUS**2
        self.assertAlmostEqual(areas.section_area(vertices[triangles], 0.5), polygon, delta=1e-12)


class Newton(unittest.TestCase):
    def test_optimum(self):
        for height, published_value, nose in ((0.4, 2.107369, 0.66640), (0.7, 1.568504, 0.48563), (1, 1.177519, 0.35094),
                                              (1.5, 0.752592, 0.20373), (2, 0.503992, 0.12086)):
            value, radius, _ = newton.least(height)
            self.assertAlmostEqual(value, published_value, delta=1e-6)
            self.assertAlmostEqual(radius, nose, delta=1e-5)
            self.assertAlmostEqual(newton.lower_bound(height), value, delta=2e-5)  # 500 stations

    def test_cone(self):
        for height in (0.4, 2):
            vertices, triangles = arrays(surfaces.KINDS[f"frustum_{height}"](10000))
            rings = newton.profile(vertices)
            slope = height / 0.7
            self.assertAlmostEqual(rings[-1, 1], 1, delta=1e-12)
            around = int(np.sum(abs(vertices[:, 0] + height) < 1e-12)) // (np.sum(rings[:, 0] == -height))
            facet = slope / math.cos(math.pi / around) / math.sqrt(2 * math.pi / (around * math.sin(2 * math.pi / around)))
            value, disc = newton.resistance(vertices, triangles)
            self.assertAlmostEqual(disc, math.pi, delta=1e-12)
            self.assertAlmostEqual(value, math.pi * (0.09 + 0.91 / (1 + facet**2)), delta=1e-12)
            self.assertAlmostEqual(newton.resistance(vertices, triangles[:, ::-1])[0], value, delta=1e-12)
            self.assertGreater(value, newton.least(height)[0] * 1.01)


class Trefftz(unittest.TestCase):
    def test_known_systems(self):
        e = trefftz.systems(count=60)
        for name, value, tolerance in (("plane", 1, 1e-9), ("dihedral", 1.0291, 2e-4), ("biplane", 1.3546, 1e-4), ("tip plates", 1.3819, 2e-4),
                                       ("winglets", 1.4186, 1e-3), ("box", 1.4717, 1e-3)):
            self.assertAlmostEqual(e[name], value, delta=tolerance, msg=name)
        half = trefftz.min_drag_of_half([(0, 0), (0.5, 0), (0.5, 0.2)], 200)
        self.assertAlmostEqual(half, 1.4186, delta=3e-3)
        self.assertAlmostEqual(trefftz.min_drag_of_half([(0, 0), (2, 0)], 40), 1, delta=1e-9)


class Nose(unittest.TestCase):
    def test_cones(self):
        """The published numbers, and the limits: slender cones by Ward's formula, a shock that is as weak, Newton's law."""
        for mach, value in ((2, 0.095529), (6, 0.065070)):
            self.assertAlmostEqual(cone.pressure_coefficient(mach, math.atan(1 / 6)), value, delta=1e-6)
        errors = []
        for delta in (math.radians(4), math.radians(2)):
            ward = delta**2 * (2 * math.log(2 / (math.sqrt(3) * delta)) - 1)
            errors.append(cone.pressure_coefficient(2, delta) / ward - 1)
        self.assertLess(errors[1], 0.02)
        self.assertGreater(errors[0] / errors[1], 2.5)  # they fall with the square of the angle
        self.assertAlmostEqual(cone.pressure_coefficient(100, 0.5) / (2 * math.sin(0.5) ** 2), 1, delta=0.06)
        self.assertGreater(cone.pressure_coefficient(100, 0.5) / (2 * math.sin(0.5) ** 2), 1.02)  # gamma is not 1

    def test_shock(self):
        turn, behind, static, total = cone.behind_shock(2, math.pi / 2)  # normal
        self.assertAlmostEqual(turn, 0, delta=1e-12)
        self.assertAlmostEqual(behind, 0.57735, delta=1e-5)
        self.assertAlmostEqual(static, 4.5, delta=1e-12)
        self.assertAlmostEqual(total, 0.72087, delta=1e-5)

    def test_profile(self):
        stations = np.linspace(0, 1, 9)
        for n in (0.68, 1):
            x, r = nose.profile(arrays(surfaces.nose(n, 4000)), stations)
            np.testing.assert_allclose(x, 3 * stations, atol=1e-12)
            np.testing.assert_allclose(r, 0.5 * stations**n, atol=2e-3 * 0.5)
            self.assertAlmostEqual(r[-1], 0.5, delta=1e-7)  # the base's area, not that of its polygon

    def test_mesh(self):
        """Closed cells in a sector without a gap; the body's faces have the sector's share of the base."""
        for exponent, mach in ((0.68, 2), (1, 6)):
            x, r = nose.mesh_points(arrays(surfaces.nose(exponent, 4000)), 20, 12, mach)
            with tempfile.TemporaryDirectory() as folder:
                nose.write_mesh(folder, x, r)
                mesh = Mesh.read(folder)
                patch = {name: foam.patch_range(folder, name) for name in ("inlet", "outlet", "front", "back", "body")}
            self.assertEqual(mesh.cells, 20 * 12)
            self.assertGreater(mesh.volumes.min(), 0)
            open_by = mesh.over_cells(mesh.areas, -mesh.areas[:mesh.inner])
            self.assertLess(np.abs(open_by).max(), 1e-12)
            self.assertEqual([len(patch[name]) for name in ("inlet", "outlet", "front", "back", "body")], [20, 12, 240, 240, 20])
            share = math.sin(nose.SECTOR) / 2 * 0.25
            self.assertAlmostEqual(mesh.areas[patch["body"], 0].sum() / share, 1, delta=1e-6)
            for name, side in (("front", 1), ("back", -1)):
                turned = mesh.areas[patch[name]] / np.linalg.norm(mesh.areas[patch[name]], axis=1)[:, None]
                np.testing.assert_allclose(turned, [[0, -math.sin(nose.SECTOR / 2), side * math.cos(nose.SECTOR / 2)]] * 240, atol=1e-9)

    @unittest.skipUnless(shutil.which("rhoCentralFoam"), "needs OpenFOAM")
    def test_drag_of_the_cone_by_the_solver(self):
        with tempfile.TemporaryDirectory() as folder:
            found = nose.drag(f"{folder}/case", arrays(surfaces.nose(1, 4000)), 6.0)
        self.assertAlmostEqual(found / 0.065070, 1, delta=0.02)

    def test_best_power(self):
        drags = [2 + 3 * (n - 0.67) ** 2 for n in published.EXPONENTS]
        np.testing.assert_allclose(published.best_power(drags), (0.67, 2), atol=1e-12)
        rising = [2 + 3 * (n - 0.5) ** 2 for n in published.EXPONENTS]
        self.assertAlmostEqual(published.best_power(rising)[0], 0.5, delta=1e-9)


class Duct(unittest.TestCase):
    def test_columns_move_alike(self):
        draw = np.random.default_rng(1)
        flat = draw.random((50, 2))
        start = np.concatenate([np.c_[flat, np.zeros(50)], np.c_[flat, np.full(50, 0.1)]])[draw.permutation(100)]
        moved, gradient = draw.random((2, 100, 3))
        mean = sbend.column_means(start, moved)
        for place in flat:
            pair = np.flatnonzero(np.all(start[:, :2] == place, axis=1))
            np.testing.assert_allclose(mean[pair, :2], np.tile(moved[pair, :2].mean(axis=0), (2, 1)), atol=1e-15)
        np.testing.assert_array_equal(mean[:, 2], moved[:, 2])
        self.assertAlmostEqual(np.sum(gradient * mean), np.sum(sbend.column_means(start, gradient) * moved), delta=1e-12)

    def test_more_than_one_layer_is_refused(self):
        with self.assertRaises(SystemExit):
            sbend.column_means(np.random.default_rng(2).random((10, 3)), np.zeros((10, 3)))


    def test_without_the_tutorial_it_is_told_and_skipped(self):
        """The other problems still run."""
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, published.__file__, "--out", folder, "sbend"], env={**os.environ, "FOAM_TUTORIALS": folder},
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("sbend: not run", done.stdout)
        self.assertIn("scripts/setup.sh openfoam", done.stdout)
        self.assertNotIn("Traceback", done.stdout)


class WingAndBody(unittest.TestCase):
    def test_oblique_cuts(self):
        sphere = arrays(surfaces.sphere(2000))
        for roll in (0.3, 2):  # an ellipse of the same volume: area along the stream over the length of the cut
            S = areas.oblique_areas(*sphere, 1.25, roll, -1.25, 1.25, 400)
            x = -1.25 * np.cos(np.linspace(0, np.pi, 402))
            length = math.hypot(1, 0.75)
            self.assertLess(np.max(abs(S - np.pi / length * np.maximum(1 - (x / length) ** 2, 0))), 0.02)
            self.assertAlmostEqual(float(np.sum((S[1:] + S[:-1]) / 2 * np.diff(x))) / areas.volume(*sphere), 1, delta=1e-3)


class Stokes(unittest.TestCase):
    def test_derivative(self):
        vertices, triangles = arrays(surfaces.sphere(80))
        random = np.random.default_rng(1)
        vertices = vertices * [1.3, 0.9, 1] + 0.03 * random.normal(size=vertices.shape)
        body, way = stokes.Body(vertices, triangles), random.normal(size=vertices.shape)
        body.drag()
        slope = float(np.sum(body.gradient() * way))
        value = lambda h: stokes.Body(vertices + h * way, triangles).drag()
        self.assertAlmostEqual(order(value, slope, 1e-3), 2, delta=0.1)
        self.assertAlmostEqual(order(value, 1.5 * slope, 1e-3), 1, delta=0.1)

    def test_sphere_and_spheroid(self):
        vertices, triangles = arrays(surfaces.sphere(500))
        radius = (areas.volume(vertices, triangles) * 3 / 4 / math.pi) ** (1 / 3)
        drag = stokes.Body(vertices, triangles).drag()
        self.assertAlmostEqual(drag / (6 * math.pi * radius), 1, delta=2e-3)
        self.assertAlmostEqual(stokes.Body(2 * vertices, triangles).drag() / (2 * drag), 1, delta=1e-5)
        for aspect in (1.3, 1.952):
            stretched = vertices * [aspect ** (2 / 3), aspect ** (-1 / 3), aspect ** (-1 / 3)]
            self.assertAlmostEqual(stokes.Body(stretched, triangles).drag() / drag, published.spheroid(aspect), delta=2e-4)


class VortexLattice(unittest.TestCase):
    def test_derivative(self):
        vertices, triangles = arrays(surfaces.rectangular_wing(10, 1200))
        random = np.random.default_rng(1)
        moved = vertices.copy()
        moved[:, 2] += 0.02 * vertices[:, 1] ** 2 * vertices[:, 0]
        way, by_alpha = 0.1 * random.normal(size=vertices.shape), 0.3
        values, gradients = lattice.evaluate(vertices, triangles, moved, 0.1)
        for name in values:
            slope = float(np.sum(gradients[name][0] * way) + gradients[name][1] * by_alpha)
            value = lambda h, name=name: lattice.evaluate(vertices, triangles, moved + h * way, 0.1 + h * by_alpha, False)[0][name]
            self.assertAlmostEqual(order(value, slope, 1e-3), 2, delta=0.1, msg=name)
            self.assertAlmostEqual(order(value, 1.5 * slope, 1e-3), 1, delta=0.1, msg=name)

    def test_untwisted_wing(self):
        """The efficiencies at which the published problems start; and on a slender wing that of Glauert's lifting line, solved here."""
        for span, wanted in ((6.12, 0.983), (10, 0.960)):
            vertices, triangles = arrays(surfaces.rectangular_wing(span, 1200))
            values = lattice.evaluate(vertices, triangles, vertices, 0.05, False)[0]
            self.assertAlmostEqual(values["efficiency"], wanted, delta=1e-3)
        span, alpha = 40, 0.01
        vertices, triangles = arrays(surfaces.rectangular_wing(span, 1200))
        values = lattice.evaluate(vertices, triangles, vertices, alpha, False)[0]
        n, t = np.arange(1, 100, 2), np.pi / 2 * (np.arange(50) + 0.5) / 50
        mu = 2 * np.pi / (4 * span)
        A = np.linalg.solve(np.sin(np.outer(t, n)) * (mu * n + np.sin(t)[:, None]), mu * alpha * np.sin(t))
        # The line knows no chord: it misses what happens within a chord of the ends, a share of the order of 1 / span.
        self.assertAlmostEqual(values["lift"] / (np.pi * span * A[0]), 1, delta=1 / span)
        self.assertAlmostEqual(values["efficiency"] * np.sum(n * (A / A[0]) ** 2), 1, delta=3 / span)


class NewtonWithoutSymmetry(unittest.TestCase):
    def test_polygons(self):
        """Those of Lachand-Robert and Oudet, computed here."""
        for height, (corners, resistance, _) in published.POLYGONS.items():
            self.assertAlmostEqual(newton_hull.best_polygon(height, corners, 720), resistance, delta=6e-5)

    def test_hull_of_a_cone_and_its_derivative(self):
        self.assertAlmostEqual(newton_hull.resistance(np.array([[0.0, 0.0, 2.0]]), 2880)[0], math.pi / 5, delta=2e-6)
        points = newton_hull.start(1.0)
        points[:, 2] -= 0.01 * np.arange(len(points)) / len(points)  # no four in a plane
        direction = np.random.default_rng(5).normal(size=points.shape)
        value = lambda h: newton_hull.resistance(points + h * direction)[0]
        slope = float(np.sum(newton_hull.resistance(points)[1] * direction))
        self.assertGreater(order(value, slope, 4e-5), 1.9)
        self.assertLess(order(value, 1.01 * slope, 4e-5), 1.5)


class TransonicWing(unittest.TestCase):
    def test_bend_of_a_sphere(self):
        """Normals out of the fluid, inward: they turn by -1/R in all directions along the wall."""
        n, radius = 24, 2.0
        u, v = np.meshgrid(np.linspace(0.8, 1.6, n), np.linspace(0, 0.8, n), indexing="ij")
        points = radius * np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
        corners = np.arange(n * n).reshape(n, n)
        faces = np.stack([corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=-1).reshape(-1, 4)
        at = points.reshape(-1, 3)[faces]
        mesh = types.SimpleNamespace(areas=-np.cross(at[:, 2] - at[:, 0], at[:, 3] - at[:, 1]) / 2, centres=at.mean(1))
        bend = m6.wall_bend(mesh, np.arange(len(faces)), faces)
        normal = mesh.areas / np.linalg.norm(mesh.areas, axis=1)[:, None]
        flat = (np.eye(3) - normal[:, :, None] * normal[:, None, :]) / -radius
        inner = np.ones((n - 1, n - 1), bool)
        inner[[0, -1], :] = inner[:, [0, -1]] = False
        self.assertLess(np.abs(bend - flat)[inner.ravel()].max(), 0.01 / radius)

    def test_section_and_planform(self):
        x = np.linspace(0, 1, 2001)
        thick = 2 * np.array([surfaces.onera_d(k) for k in x])
        self.assertAlmostEqual(thick.max(), 0.098, delta=5e-4)
        vertices, triangles = arrays(surfaces.onera_m6(3000))
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        kinds, count = np.unique(edges, axis=0, return_counts=True)
        self.assertTrue(np.all(vertices[kinds[count == 1].ravel(), 1] == 0))  # open at the root alone
        self.assertLessEqual(count.max(), 2)
        tip = 0.8059 * 0.562
        chords = 1.1963 * (0.8059**2 + 0.8059 * tip + tip**2) / 3
        volume = chords * np.trapz(thick, x) + math.pi / 2 * tip**3 * np.trapz((thick / 2) ** 2, x)
        self.assertAlmostEqual(areas.volume(vertices, triangles) / volume, 1, delta=0.005)

    def test_zero_lift_angle(self):
        """A turn by 0.01 nose up, and a parabola of camber h, whose angle is -2 h."""
        made = m6.layout(1)
        points = m6.around_wing.mirrored(made.upper()[0][:made.chord + 1]).reshape(-1, 3)
        front, chord = points[:, 1] * math.tan(math.radians(30)), 0.8059 * (1 - 0.438 * np.minimum(points[:, 1] / 1.1963, 1))
        x = (points[:, 0] - front) / chord
        for camber, angle in ((-0.01 * x, -0.01), (4 * 0.02 * x * (1 - x), -0.04)):
            shift = np.stack([0 * x, 0 * x, camber * chord], axis=1)
            self.assertAlmostEqual(m6.zero_lift_angle(points, shift), angle, delta=4e-4)


class Page(unittest.TestCase):
    """What published.sh and published_levels.py write."""

    def test_rows_take_the_place_of_those_of_the_same_problem(self):
        def results(value, *names):
            return [(name, 100, [published.Row("a", "1", value, True), published.Row("b", "", 2, None)], 3, 4.0, "") for name in names]
        table = published.tables(results(1, "haack", "stokes"))
        self.assertEqual(published.merged(table, []), table)
        self.assertEqual(published.merged(table, results(9, "stokes")), published.tables(results(1, "haack") + results(9, "stokes")))
        self.assertEqual(published.merged(table, results(1, "newton_1")), published.tables(results(1, "haack", "newton_1", "stokes")))

    def test_table_of_levels_counts_evaluations(self):
        one = {"variant": "box", "excess": [3.0, None, 0.09, 0.2, 0.002], "seconds": 7.4, "end": "budget"}
        self.assertIn("| `haack` | box | 3 | 5 | – | 0.2 | 5 | 7 | budget |", published_levels.table({"haack": [one]}))
        x, y = np.array([[float(c) for c in point.split(",")] for point in published_levels.curve(one["excess"], 5).split()]).T
        self.assertTrue(np.all(np.diff(x) >= 0) and np.all(np.diff(y) >= 0))
        self.assertAlmostEqual(x[-1], published_levels.WIDTH)
        self.assertEqual(published_levels.curve([None, None], 2), "")

    def test_variants_of_cases_change_what_they_say(self):
        """A case whose line of parameters reads otherwise would be run as it is."""
        for name in published_levels.LEAST:
            text = (published.CASES / f"{published.PROBLEMS[name].case or name}.yaml").read_text(encoding="utf-8")
            made = {variant: published_levels.varied(text, variant) for variant in published_levels.VARIANTS}
            by_values = "fields: auto" in text
            self.assertIn("fields: auto" if by_values else "number: auto", made["fields, coarse to fine"])
            self.assertIn("fields: {number: 60}" if by_values else text, made["finest only"])
            if name not in published_levels.ONLY_FIELDS:
                if by_values:
                    self.assertIn("fields: none", made["patches"])
                else:
                    self.assertIn("levels: auto, variables: [normal], max_displacement: ", made["patches"])
                    self.assertNotIn("fields:", made["patches"])
                self.assertIn("variables: [normal]", made["fields and patches"])
                self.assertNotIn("shell: none", made["fields and patches"])


if __name__ == "__main__":
    unittest.main()
