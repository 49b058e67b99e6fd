#!/usr/bin/env python3
"""Every way to choose against a computation from the file alone: choices_test.py STRAKE MAKE_SURFACE [TRIANGLES...] (default 2000).

The lasso and the rectangle need a Chromium, and are left out without one. Nothing here asks Strake what a triangle is: corners, edges, angles,
distances and what hides what come from the STL's numbers. Only patches are taken from what the server says they are.
"""
import base64
import bisect
import collections
import heapq
import json
import math
import os
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from browser import Browser, find_chromium  # noqa: E402
from studio_at_work import Studio  # noqa: E402

STRAKE, MAKE_SURFACE = sys.argv[1:3]
SIZES = [int(n) for n in sys.argv[3:]] or [2000]


def minus(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class File:
    """The triangles of a binary STL, welded where coordinates are equal."""

    def __init__(self, path):
        data, number, self.points, self.triangles = path.read_bytes(), {}, [], []
        for t in range(struct.unpack_from("<I", data, 80)[0]):
            numbers, corners = struct.unpack_from("<12f", data, 84 + 50 * t), []
            for k in (3, 6, 9):
                point = tuple(c + 0.0 for c in numbers[k:k + 3])
                if point not in number:
                    number[point] = len(self.points)
                    self.points.append(point)
                corners.append(number[point])
            self.triangles.append(corners)
        self.normals = [cross(minus(self.points[b], self.points[a]), minus(self.points[c], self.points[a])) for a, b, c in self.triangles]
        self.low, self.high = ([side(p[a] for p in self.points) for a in range(3)] for side in (min, max))
        self.size = minus(self.high, self.low)
        self.diagonal = math.sqrt(dot(self.size, self.size))
        self.beside = collections.defaultdict(list)
        for t, corners in enumerate(self.triangles):
            for k in range(3):
                self.beside[tuple(sorted((corners[k], corners[(k + 1) % 3])))].append(t)

    def those(self, holds):
        """Triangles whose three corners fulfil it."""
        marks = [holds(p) for p in self.points]
        return {t for t, (a, b, c) in enumerate(self.triangles) if marks[a] and marks[b] and marks[c]}

    def middle(self, t):
        return tuple(sum(self.points[v][a] for v in self.triangles[t]) / 3 for a in range(3))

    def flooded(self, begin, degrees):
        reached, todo = {begin}, [begin]
        while todo:
            t = todo.pop()
            corners = self.triangles[t]
            for k in range(3):
                both = self.beside[tuple(sorted((corners[k], corners[(k + 1) % 3])))]
                if len(both) != 2:
                    continue
                s = both[0] + both[1] - t
                n, m = self.normals[t], self.normals[s]
                if s not in reached and math.degrees(math.atan2(math.sqrt(dot(cross(n, m), cross(n, m))), dot(n, m))) <= degrees:
                    reached.add(s)
                    todo.append(s)
        return reached

    def grown(self, chosen, by):
        """All corners within a length along edges."""
        if by < 0:
            return set(range(len(self.triangles))) - self.grown(set(range(len(self.triangles))) - chosen, -by)
        links = collections.defaultdict(list)
        for a, b in self.beside:
            d = minus(self.points[a], self.points[b])
            links[a].append((b, math.sqrt(dot(d, d))))
            links[b].append((a, math.sqrt(dot(d, d))))
        far = dict.fromkeys((v for t in chosen for v in self.triangles[t]), 0.0)
        todo = [(0.0, v) for v in far]
        while todo:
            reached, v = heapq.heappop(todo)
            if reached > far[v]:
                continue
            for w, length in links[v]:
                if reached + length <= by * (1 + 1e-9) and reached + length < far.get(w, math.inf):
                    far[w] = reached + length
                    heapq.heappush(todo, (far[w], w))
        return chosen | {t for t, corners in enumerate(self.triangles) if all(v in far for v in corners)}


class Choices(unittest.TestCase):
    body, triangles = "lifting_body", 2000

    @classmethod
    def setUpClass(cls):
        cls.around = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.around.name) / "work"
        folder.mkdir()
        os.environ["XDG_CACHE_HOME"] = str(pathlib.Path(cls.around.name) / "cache")
        subprocess.run([MAKE_SURFACE, cls.body, "--triangles", str(cls.triangles), "-o", folder / "body.stl"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.studio = subprocess.Popen([STRAKE, "studio", "body.stl", "--no-browser"], cwd=folder, stdout=subprocess.PIPE, text=True)
        cls.url = cls.studio.stdout.readline().strip()
        cls.file = File(folder / "body.stl")
        while json.loads(cls.get("api/state"))["is_opening"]:
            time.sleep(0.1)
        answer = cls.get("api/surface")
        length = struct.unpack_from("<I", answer)[0]
        cls.facts = json.loads(answer[4:4 + length])
        cls.array = classmethod(lambda own, name: struct.unpack_from(f"<{own.facts['arrays'][name]['count']}I", answer, 4 + length + own.facts["arrays"][name]["offset"]))
        cls.everything = set(range(len(cls.file.triangles)))

    @classmethod
    def tearDownClass(cls):
        cls.studio.send_signal(signal.SIGTERM)
        cls.studio.communicate(timeout=20)
        cls.around.cleanup()

    @classmethod
    def get(cls, path):
        return urllib.request.urlopen(cls.url + path, timeout=600).read()

    def chosen(self, *steps):
        body = json.dumps({"do": "choose", "steps": [{"op": "+", **s} for s in steps], "text": ""}).encode()
        asked = urllib.request.Request(self.url + "api", body, {"Content-Type": "application/json"})
        found = json.loads(urllib.request.urlopen(asked, timeout=600).read())
        bits = base64.b64decode(found["marks"])
        return {t for t in self.everything if (bits[t >> 3] >> (t & 7)) & 1}

    def place(self, axis, share):
        """Between vertices: no rounding decides."""
        at = self.file.low[axis] + share * self.file.size[axis]
        values = sorted({p[axis] for p in self.file.points})
        k = next((k for k, v in enumerate(values) if v > at), len(values) - 1)
        return (values[k - 1] + values[k]) / 2

    def same(self, found, expected):
        self.assertEqual(found ^ expected, set())
        self.assertTrue(found and found != self.everything, "something, not all")

    def test_planes_and_boxes(self):
        for normal in ((1, 0, 0), (0, 1, 0), (0.48, 0.6, 0.64)):
            at = (self.place(normal.index(1), 0.37) if 1 in normal else dot(normal, self.file.low) + 0.4137 * dot([abs(n) for n in normal], self.file.size))
            below = self.chosen({"plane": {"normal": normal, "at": at, "above": False}})
            self.same(below, self.file.those(lambda p: dot(normal, p) <= at))
            self.same(self.chosen({"plane": {"normal": normal, "at": at, "above": True}}), self.file.those(lambda p: dot(normal, p) >= at))
        low, high = ([self.place(a, s) for a in range(3)] for s in (0.1, 0.8))
        self.same(self.chosen({"box": [low, high]}), self.file.those(lambda p: all(low[a] <= p[a] <= high[a] for a in range(3))))

    def test_patches_and_parts(self):
        for level in self.facts["levels"]:
            label = self.array(level["array"])
            for number in (0, len(level["patches"]) - 1):
                self.same(self.chosen({"patch": level["patches"][number]}), {t for t in self.everything if label[t] == number})
        part = self.file.flooded(0, 180)
        self.assertEqual(self.chosen({"component": self.array("component")[0]}), part)

    def test_floods(self):
        triangle = len(self.everything) // 3
        sharp = sorted(math.degrees(math.atan2(math.sqrt(dot(cross(n, m), cross(n, m))), dot(n, m))) for n, m in
                       ((self.file.normals[a], self.file.normals[b]) for a, b in (both for both in self.file.beside.values() if len(both) == 2)))
        for share in (0.97, 0.995):
            k = int(share * len(sharp))
            angle = (sharp[k] + sharp[k + 1]) / 2
            if sharp[k + 1] - sharp[k] < 1e-6 or not 0 < angle < 180:
                continue
            self.assertEqual(self.chosen({"flood": {"point": self.file.middle(triangle), "angle": angle}}), self.file.flooded(triangle, angle))

    def test_combinations(self):
        low, high = ([self.place(a, s) for a in range(3)] for s in (0.15, 0.9))
        at = self.place(0, 0.55)
        box, plane = {"box": [low, high]}, {"plane": {"normal": [1, 0, 0], "at": at, "above": False}}
        a, b = self.chosen(box), self.chosen(plane)
        self.same(self.chosen(box, plane), a | b)
        self.same(self.chosen(box, {**plane, "op": "-"}), a - b)
        self.same(self.chosen(box, {**plane, "op": "&"}), a & b)
        self.same(self.chosen(box, {"invert": True}), self.everything - a)
        self.same(self.chosen(box, {**plane, "op": "&"}, {"invert": True}, {**plane, "op": "-"}), self.everything - b)
        for by in (0.02, -0.02):
            self.same(self.chosen(plane, {"grow": by * self.file.diagonal}), self.file.grown(b, by * self.file.diagonal))
        self.assertEqual(self.chosen({"all": True}), self.everything)
        some = {3, 7, len(self.everything) - 1}
        self.assertEqual(self.chosen({"triangles": sorted(some)}), some)

    def test_mirror_images(self):
        symmetry = self.facts["symmetry"]
        if not symmetry or symmetry["is_half"]:
            self.skipTest("half a body")
        axis = max(range(3), key=lambda a: abs(symmetry["normal"][a]))
        self.assertAlmostEqual(abs(symmetry["normal"][axis]), 1, delta=1e-9)
        at = self.place(axis, 0.2)
        plane = {"plane": {"normal": [float(a == axis) for a in range(3)], "at": at, "above": False}}
        centre = symmetry["offset"] * symmetry["normal"][axis]
        found, one = self.chosen(plane, {"mirror": symmetry}), self.chosen(plane)
        expected = one | self.file.those(lambda p: p[axis] >= 2 * centre - at)
        self.assertLessEqual(len(found ^ expected), 0.02 * len(expected), "both sides are not triangulated alike to the last row")
        self.assertGreater(len(found), 1.9 * len(one))

    def test_parts_of_wings(self):
        if not self.facts["wings"] or self.body != "wing":
            self.skipTest("no wing")
        def chain(sign):
            """(span, x) of an edge of the planform, which is straight or bulges outward."""
            found = []
            for y, x in sorted((p[1], sign * p[0]) for p in self.file.points):
                while len(found) > 1 and (found[-1][0] - found[-2][0]) * (x - found[-2][1]) <= (found[-1][1] - found[-2][1]) * (y - found[-2][0]):
                    found.pop()
                found.append((y, x))
            return [(y, sign * x) for y, x in found]

        def on(line, y):
            k = min(max(bisect.bisect_left(line, (y, -math.inf)), 1), len(line) - 1)
            (y0, x0), (y1, x1) = line[k - 1], line[k]
            return x0 + (y - y0) / (y1 - y0) * (x1 - x0)
        leading, trailing, tip = chain(1), chain(-1), self.file.high[1]

        def fraction(p):
            begin, end = on(leading, p[1]), on(trailing, p[1])
            return (p[0] - begin) / (end - begin) if end > begin else 0.5, p[1] / tip
        places = [fraction(p) for p in self.file.points]
        for side, sign in (("both", 0), ("upper", 1)):
            found = self.chosen({"wing": {"of": "", "chord": [0.2, 0.6], "span": [0.1, 0.7], "side": side}})
            for slack, outer in ((0.01, True), (-0.01, False)):
                marks = [0.2 - slack <= c <= 0.6 + slack and 0.1 - slack <= s <= 0.7 + slack for c, s in places]
                those = {t for t, (a, b, c) in enumerate(self.file.triangles) if marks[a] and marks[b] and marks[c] and sign * self.file.normals[t][2] >= 0}
                self.assertEqual(found - those if outer else those - found, set(), f"{side}, within a hundredth of the chord")
            self.assertGreater(len(found), 0.01 * len(self.everything))


class Pointed(Choices):
    """In the page: browser_test.py moves the mouse, this one gives the line."""

    def test_lassos(self):
        if not find_chromium():
            self.skipTest("there is no chromium")
        with Browser(1280, 860) as b:
            b.open(self.url)
            b.until("document.documentElement.dataset.ready > 0", 600)
            b.click("#tab-choose")
            camera = b.run("(() => { const v = strakeStudio.scene.viewer, b = strakeStudio.scene.body; v.render(); v.camera.updateMatrixWorld(); "
                           "return { e: v.camera.matrixWorldInverse.elements, p: v.camera.projectionMatrix.elements, w: v.width, h: v.height, c: b.center }; })()")

            def on_canvas(point):
                x = [*minus(point, camera["c"]), 1.0]
                eye = [sum(camera["e"][4 * k + r] * x[k] for k in range(4)) for r in range(4)]
                clip = [sum(camera["p"][4 * k + r] * eye[k] for k in range(4)) for r in range(4)]
                return (clip[0] + 1) / 2 * camera["w"], (1 - clip[1]) / 2 * camera["h"], eye[2]
            flat = [on_canvas(p) for p in self.file.points]
            middle = [tuple(sum(flat[v][c] for v in corners) / 3 for c in range(3)) for corners in self.file.triangles]
            line = [(camera["w"] * (0.5 + 0.17 * math.cos(0.2 * k) * (1 + 0.3 * math.sin(0.6 * k))), camera["h"] * (0.5 + 0.2 * math.sin(0.2 * k))) for k in range(31)]
            box = [(0.4 * camera["w"], 0.35 * camera["h"]), (0.62 * camera["w"], 0.35 * camera["h"]), (0.62 * camera["w"], 0.7 * camera["h"]), (0.4 * camera["w"], 0.7 * camera["h"])]
            cells = collections.defaultdict(list)
            for t, corners in enumerate(self.file.triangles):
                (ax, ay, _), (bx, by, _), (cx, cy, _) = (flat[v] for v in corners)
                for i in range(int(min(ax, bx, cx) // 8), int(max(ax, bx, cx) // 8) + 1):
                    for k in range(int(min(ay, by, cy) // 8), int(max(ay, by, cy) // 8) + 1):
                        cells[i, k].append(t)

            def area(t):
                (ax, ay, _), (bx, by, _), (cx, cy, _) = (flat[v] for v in self.file.triangles[t])
                return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

            def is_seen(t):
                if area(t) >= 0:
                    return False
                x, y, z = middle[t]
                for s in cells[int(x // 8), int(y // 8)]:
                    whole = area(s)
                    if s == t or whole == 0:
                        continue
                    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (flat[v] for v in self.file.triangles[s])
                    u, v = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / whole, ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / whole
                    if min(u, v, 1 - u - v) > -1e-9 and u * az + v * bz + (1 - u - v) * cz > z + 1e-6 * self.file.diagonal:
                        return False
                return True

            def winds_around(loop, x, y):
                turn = 0.0
                for k, (ax, ay) in enumerate(loop):
                    bx, by = loop[(k + 1) % len(loop)]
                    d = math.atan2(by - y, bx - x) - math.atan2(ay - y, ax - x)
                    turn += math.atan2(math.sin(d), math.cos(d))
                return abs(turn) > math.pi
            for tool, loop in (("lasso", line), ("rectangle", box)):
                inside = {t for t, m in enumerate(middle) if winds_around(loop, m[0], m[1])}
                seen = {t for t in inside if is_seen(t)}
                for through, expected in ((True, inside), (False, seen)):
                    found = set(b.run(f"strakeStudio.scene.inLasso({json.dumps(loop)}, {json.dumps(through)})"))
                    self.assertGreater(len(expected), 20)
                    print(f"{self.body}, {len(middle)} triangles: {tool}{' through' if through else ''}: {len(found)} chosen, {len(found ^ expected)} differ", flush=True)
                    self.assertEqual(found ^ expected, set())
            self.assertEqual(b.errors, [])


class Plates(unittest.TestCase):
    """Two plates of squares, the diagonals of one across those of the other: each middle of the one behind lies on a diagonal of the one before it."""

    def test_what_lies_on_the_lines_of_others_is_hidden(self):
        if not find_chromium():
            self.skipTest("there is no chromium")
        n, lines = 20, []
        for z in (0, 3):
            lines += [f"v {-z} {i / n} {j / n}" for i in range(n + 1) for j in range(n + 1)]
        for k in (0, 1):
            for a in (1 + k * (n + 1) ** 2 + i * (n + 1) + j for i in range(n) for j in range(n)):
                b, c, d = a + n + 1, a + n + 2, a + 1
                lines += [f"f {a} {c} {b}", f"f {a} {d} {c}"] if k else [f"f {a} {d} {b}", f"f {b} {d} {c}"]
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "plates.obj").write_text("\n".join(lines) + "\n", encoding="ascii")
            with Studio(STRAKE, folder, "plates.obj") as studio, Browser(1280, 860) as b:
                b.open(studio.url.strip())
                b.until("document.documentElement.dataset.ready > 0")
                b.run("(() => { const v = strakeStudio.scene.viewer; v.look('front'); v.render(); v.camera.updateMatrixWorld(); })()")
                found = [b.run(f"strakeStudio.scene.inLasso([[0, 0], [2000, 0], [2000, 2000], [0, 2000]], {through})") for through in ("true", "false")]
        half = 2 * n * n
        self.assertEqual(found, [list(range(2 * half)), list(range(half, 2 * half))])


def load_tests(loader, _, __):
    suite = unittest.TestSuite(loader.loadTestsFromTestCase(Plates))
    for size in SIZES:
        for body in ("lifting_body", "wing"):
            made = type(f"{body}_{size}", (Pointed,), {"body": body, "triangles": size})
            suite.addTests(loader.loadTestsFromTestCase(made))
    return suite


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2 if len(sys.argv) > 3 else 1)
