#!/usr/bin/env python3
"""The server of strake studio over sockets: server_test.py STRAKE MAKE_SURFACE."""
import array
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from studio_at_work import Studio as AnyStudio

STRAKE, MAKE_SURFACE = sys.argv[1:3]


def Studio(folder, *arguments, **more):
    return AnyStudio(STRAKE, folder, *arguments, **more)


class Server(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.around = tempfile.TemporaryDirectory()
        cls.outside = pathlib.Path(cls.around.name)
        cls.folder = cls.outside / "mine"
        cls.folder.mkdir()
        os.environ["XDG_CACHE_HOME"] = str(cls.outside / "cache")
        subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1500", "-o", cls.folder / "body.stl"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        (cls.outside / "secret.yaml").write_text("surface: secret\n")
        (cls.outside / "secret.stl").write_bytes((cls.folder / "body.stl").read_bytes())
        os.symlink(cls.outside / "secret.yaml", cls.folder / "link.yaml")

    @classmethod
    def tearDownClass(cls):
        cls.around.cleanup()

    def setUp(self):
        self.studio = Studio(self.folder, "body.stl")
        self.addCleanup(self.studio.process.stdout.close)
        self.addCleanup(self.studio.process.stderr.close)
        self.addCleanup(lambda: self.studio.process.poll() is not None or self.studio.end(signal.SIGKILL))

    def opened(self):
        return self.studio.until(lambda s: not s["is_opening"])

    def test_answers_its_own_page_and_says_what_a_page_may_do(self):
        status, page = self.studio.request("")
        self.assertEqual(status, 200)
        policy = self.studio.headers["Content-Security-Policy"]
        self.assertIn("default-src 'none'", policy)
        self.assertNotIn("unsafe", policy)
        self.assertNotIn("http", policy)
        self.assertEqual(self.studio.headers["Referrer-Policy"], "no-referrer")
        self.assertEqual(self.studio.headers["Cache-Control"], "no-store")
        self.assertIn(b'src="studio.js"', page)
        self.assertIsNone(re.search(rb"https?://", page))
        self.assertIsNone(re.search(rb"<script>|<style>| on[a-z]+=| style=", page), "nothing inline")
        for name in ("studio.js", "studio.css"):
            self.assertEqual(self.studio.request(name)[0], 200)

    def test_listens_on_the_loopback_address_only(self):
        listening = pathlib.Path(f"/proc/{self.studio.process.pid}/net/tcp").read_text()
        ports = [line.split()[1] for line in listening.splitlines()[1:] if line.split()[3] == "0A"]
        self.assertIn(f"0100007F:{self.studio.port:04X}", ports)
        self.assertNotIn(f"00000000:{self.studio.port:04X}", ports)

    def test_refuses_other_hosts(self):
        for host in ("evil.example", f"evil.example:{self.studio.port}", "127.0.0.1", "localhost:1"):
            self.assertEqual(self.studio.request("", headers={"Host": host})[0], 403, host)
        self.assertEqual(self.studio.request("", headers={"Host": f"localhost:{self.studio.port}"})[0], 200)
        line = f"GET /{self.studio.token}/ HTTP/1.1\r\n".encode()
        self.assertIn(b" 403 ", self.studio.raw(line + b"\r\n").split(b"\r\n")[0] + b" ")

    def test_refuses_other_pages(self):
        for origin in ("http://evil.example", "null", f"https://127.0.0.1:{self.studio.port}"):
            self.assertEqual(self.studio.request("api/state", headers={"Origin": origin})[0], 403, origin)
        self.assertEqual(self.studio.request("api/state", headers={"Sec-Fetch-Site": "cross-site"})[0], 403)
        self.assertEqual(self.studio.request("api/state", headers={"Origin": f"http://127.0.0.1:{self.studio.port}"})[0], 200)

    def test_refuses_requests_without_the_token(self):
        for token in ("", "x", "0" * 32, self.studio.token[:-1], self.studio.token + "0", "..", "%2e%2e"):
            for path in ("", "api/state", "api/surface", "studio.js"):
                self.assertEqual(self.studio.request(path, token=token)[0], 404, token)
        other = self.studio.request("api", "POST", b'{"do":"open","name":"body.stl"}', {"Content-Type": "application/json"}, "0" * 32)
        self.assertEqual(other[0], 404)
        self.assertNotIn(self.studio.token.encode(), other[1])

    def test_refuses_bodies_above_the_limit_and_of_unknown_length(self):
        json_type = {"Content-Type": "application/json"}
        head = f"POST /{self.studio.token}/api HTTP/1.1\r\nHost: 127.0.0.1:{self.studio.port}\r\nContent-Type: application/json\r\n"
        answer = self.studio.raw((head + f"Content-Length: {(4 << 20) + 1}\r\n\r\n").encode() + b"x")
        self.assertTrue(answer.startswith(b"HTTP/1.1 413"), answer[:60])
        answer = self.studio.raw((head + "Transfer-Encoding: chunked\r\n\r\n").encode() + b"5\r\n{\"a\":\r\n" * 10)
        self.assertTrue(answer.startswith(b"HTTP/1.1 411"), answer[:60])
        answer = self.studio.raw((head + "Content-Length: 30\r\nContent-Encoding: gzip\r\n\r\n").encode() + b"x" * 30)
        self.assertTrue(answer.startswith(b"HTTP/1.1 411"), answer[:60])
        self.assertEqual(self.studio.request("api", "POST", "{}", {"Content-Type": "text/plain"})[0], 415)
        self.assertEqual(self.studio.request("api", "PUT", "{}", json_type)[0], 405)
        self.assertEqual(self.studio.request("api", "POST", " " * (3 << 20) + '{"do": "choose"}', json_type)[0], 409, "below the limit")

    def test_a_header_without_an_end_is_not_read_to_the_end(self):
        with socket.create_connection(("127.0.0.1", self.studio.port), timeout=10) as link:
            link.sendall(b"GET /" + self.studio.token.encode() + b"/ HTTP/1.1\r\nX: ")
            sent, answer = 0, b""
            try:
                while sent < (64 << 20):
                    sent += link.send(b"x" * 65536)
            except OSError:
                pass
            try:
                answer = link.recv(1000)
            except OSError:
                pass
        self.assertLess(sent, 8 << 20, "the studio has closed the connection")
        self.assertIn(answer[:12], (b"HTTP/1.1 431", b""))
        memory = int(re.search(r"VmHWM:\s+(\d+)", pathlib.Path(f"/proc/{self.studio.process.pid}/status").read_text())[1])
        self.assertLess(memory, 400_000, "kB")
        answer = self.studio.raw(b"GET / HTTP/1.1\r\nX: " + b"x" * 20000 + b"\r\n\r\n")
        self.assertTrue(answer.startswith(b"HTTP/1.1 431"), answer[:60])

    def test_slow_requests_hold_up_nobody(self):
        links = [socket.create_connection(("127.0.0.1", self.studio.port), timeout=20) for _ in range(3)]
        for link in links:
            link.sendall(b"GET / HT")
        begin = time.monotonic()
        self.assertEqual(self.studio.request("")[0], 200)
        self.assertLess(time.monotonic() - begin, 5)
        for link in links:
            link.close()

    def test_keeps_its_address_from_start_to_start(self):
        before = self.studio.url
        kept = [*(self.outside / "cache/strake").iterdir()]
        self.assertTrue(all(file.stat().st_mode & 0o077 == 0 for file in kept), "nobody else reads it")
        self.studio.end(signal.SIGKILL)
        with Studio(self.folder, "body.stl") as again:
            self.assertEqual(again.url, before)
            with Studio(self.folder, "body.stl") as second:
                self.assertNotEqual(second.url.split("/")[3], again.token, "a second one beside it has its own")
        with Studio(self.folder, "body.stl", "--new-address") as other:
            self.assertNotEqual(other.url.split("/")[3], before.split("/")[3])
        for file in kept:
            file.chmod(0o644)
        with Studio(self.folder, "body.stl") as distrustful:
            self.assertNotEqual(distrustful.token, other.token, "others may have read that file")

    def test_a_refused_body_is_no_second_request(self):
        inner = f"GET /{self.studio.token}/api/state HTTP/1.1\r\nHost: 127.0.0.1:{self.studio.port}\r\n\r\n"
        answer = self.studio.raw((f"POST /x/api HTTP/1.1\r\nHost: 127.0.0.1:{self.studio.port}\r\nContent-Length: {len(inner)}\r\n\r\n"
                                  + inner).encode())
        self.assertEqual(answer.count(b"HTTP/1.1 "), 1)

    def test_refuses_paths_outside_of_the_folder(self):
        self.opened()
        for name in ("../secret.yaml", "../secret.stl", str(self.outside / "secret.yaml"), "link.yaml", "x/../../secret.yaml",
                     "/etc/passwd", "", ".\0"):
            for what in ("open", "attach"):
                status, answer = self.studio.post(what, name=name)
                self.assertEqual(status, 409, name)
                self.assertNotIn("secret\n", json.dumps(answer))
            status, answer = self.studio.post("save", name=name, text="surface: body.stl\n", mark="")
            self.assertEqual(status, 409, name)
        self.assertEqual((self.outside / "secret.yaml").read_text(), "surface: secret\n")
        self.assertEqual(self.studio.post("propose", name="../made.yaml")[0], 409)
        self.assertEqual(self.studio.post("region", text="", name="../x", steps=[{"triangles": [1, 5, 9]}])[0], 409)
        for path in ("../secret.yaml", "api/../../secret.yaml", "%2e%2e/secret.yaml", "body.stl"):
            self.assertEqual(self.studio.raw(f"GET /{self.studio.token}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{self.studio.port}\r\n\r\n"
                                             .encode())[:12], b"HTTP/1.1 404", path)

    def test_refuses_what_it_does_not_understand(self):
        self.opened()
        for body in (b"", b"{", b"[]", b"1", b'{"do": 3}', b'{"do": "fly"}', b'{"do":"choose"}', b'{"do":"choose","text":""}',
                     b'{"do":"choose","text":"","steps":[{"patch":7}]}', b'{"do":"choose","text":"","steps":[{"box":[[1,1,1],[0,0,0]]}]}',
                     b'{"do":"choose","text":"","steps":[{"plane":{"normal":[0,0,0],"at":1,"above":true}}]}',
                     b'{"do":"choose","text":"","steps":[{"triangles":[-1]}]}', b'{"do":"choose","text":"","steps":[{"triangles":[99999999999]}]}',
                     b'{"do":"choose","text":"","steps":[{"flood":{"point":[0,0],"angle":3}}]}',
                     b'{"do":"choose","text":"","steps":[{"grow":1e999}]}', b"[" * 100000, b"\xff\xfe"):
            status, words = self.studio.request("api", "POST", body, {"Content-Type": "application/json"})
            self.assertIn(status, (400, 404, 409), body[:60])
            self.assertTrue(words)
        self.assertEqual(self.studio.request("")[0], 200, "still at work")

    def test_chooses_what_the_surface_says(self):
        self.opened()
        data = self.studio.request("api/surface")[1]
        length = int.from_bytes(data[:4], "little")
        facts = json.loads(data[4:4 + length])
        def values(name, code):
            place = facts["arrays"][name]
            found = array.array(code)
            found.frombytes(data[4 + length + place["offset"]:][:4 * place["count"]])
            return found
        x, t = values("positions", "f"), values("triangles", "I")
        at = facts["center"][0] + 0.11 * facts["diagonal"]
        expected = sum(all(x[3 * v] + facts["center"][0] <= at for v in t[3 * k:3 * k + 3]) for k in range(len(t) // 3))
        self.assertTrue(0 < expected < len(t) // 3)
        status, found = self.studio.post("choose", text="", name="front", steps=[{"plane": {"normal": [2, 0, 0], "at": at, "above": False}}])
        self.assertEqual((status, found["triangles"], found["kind"]), (200, expected, "plane"))

    def test_saves_only_what_it_has_seen(self):
        self.opened()
        case = self.folder / "saved.yaml"
        status, made = self.studio.post("save", name="saved.yaml", text="surface: {file: body.stl}\nobjective: {maximize: volume}\n", mark="")
        self.assertEqual(status, 200)
        self.addCleanup(case.unlink)
        self.studio.until(lambda s: s["case"] == "saved.yaml" and not s["is_opening"])
        case.write_text("surface: body.stl  # by another program\n")
        self.assertNotEqual(self.studio.state()["disk_mark"], made["mark"])
        status, answer = self.studio.post("save", text="surface: mine\n", mark=made["mark"])
        self.assertTrue(answer["changed"])
        self.assertIn("another program", answer["text"])
        self.assertIn("another program", case.read_text())
        status, answer = self.studio.post("save", text="surface: body.stl\n", mark=answer["mark"])
        self.assertEqual(case.read_text(), "surface: body.stl\n")
        self.assertTrue(self.studio.post("save", name="saved.yaml", text="surface: x\n", mark="")[1]["changed"], "no new file over an old one")
        self.assertEqual([f.name for f in self.folder.iterdir() if f.name.startswith("saved")], ["saved.yaml"], "no other file stays")

    def test_a_list_of_triangles_takes_the_place_of_no_file_of_the_users(self):
        self.opened()
        own = self.folder / "scraps-triangles.txt"
        own.write_text("7\n")
        self.addCleanup(own.unlink)
        picked = [{"triangles": [1, 500, 900]}]
        status, answer = self.studio.post("region", text="surface: body.stl\n", name="scraps", steps=picked)
        self.assertEqual(status, 409)
        self.assertIn("exists already", answer["error"])
        self.assertEqual(own.read_text(), "7\n")
        status, answer = self.studio.post("region", text="surface: body.stl\nregions:\n  scraps: {triangles: scraps-triangles.txt}\n", name="scraps", steps=picked)
        self.assertEqual(status, 200, "the region's own list is written again")
        self.assertEqual(own.read_text(), "1\n500\n900\n")

    def test_checks_a_text_without_running_or_writing_anything(self):
        self.opened()
        trap = self.folder / "trap"
        yaml = (f"surface: {{file: body.stl}}\nregions:\n  a: {{box: [[0, 0, 0], [1, 1, 1]], sied: below}}\n  b: {{patch: p77}}\n"
                f"quantities: {{q: {{command: [touch, '{trap}']}}}}\nobjective: {{maximize: q}}\n")
        status, found = self.studio.post("check", text=yaml)
        self.assertEqual(status, 200)
        self.assertEqual([e["line"] for e in found["errors"]], [3])
        status, found = self.studio.post("check", text=yaml.replace(", sied: below", ""))
        self.assertEqual([e["line"] for e in found["errors"]], [4], found)
        self.assertIn("p77", found["errors"][0]["message"])
        self.assertFalse(trap.exists())

    def felt(self, wish, seconds=100):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            state = json.loads(self.studio.request("api/felt_state")[1])
            if state["done"] >= wish:
                return state
            time.sleep(0.02)
        raise RuntimeError(f"no answer to wish {wish}: {state}")

    def numbers(self, path):
        status, body = self.studio.request(path)
        self.assertEqual(status, 200, body[:200])
        return array.array("f", body)

    def test_the_linear_preview_is_the_derivative_of_the_exact_shape(self):
        self.opened()
        yaml = ("surface: {file: body.stl}\nregions: {root: {plane: {normal: [1, 0, 0], at: 0.8}, side: below}}\nfixed: [root]\n"
                "objective: {maximize: volume}\nparameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 4%}\n")
        status, asked = self.studio.post("feel", text=yaml)
        self.assertEqual(status, 200, asked)
        variables = self.felt(asked["wish"])["answer"]["variables"]
        self.assertGreater(len(variables), 1)
        shapes = []
        for step in (0.0, 0.02, 0.04):
            x = [step] + [0.0] * (len(variables) - 1)
            wish = self.studio.post("feel", text=yaml, level=1, x=x, slope=True)[1]["wish"]
            state = self.felt(wish)
            answer = state["answer"]
            self.assertEqual(answer["status"], "ok", answer)
            self.assertEqual(state["shape_of"], wish)
            self.assertGreater(state["shapes"], len(shapes), "each new shape counts")
            shapes.append((self.numbers(f"api/felt/shape?of={wish}"), answer["values"]["volume"], self.numbers("api/felt/slope")))
        end = time.monotonic() + 60
        while json.loads(self.studio.request("api/felt_state")[1])["modes"] < len(variables) and time.monotonic() < end:
            time.sleep(0.05)
        mode = self.numbers("api/felt/mode?j=0")
        largest = max(map(abs, mode))
        misses = [max(abs(now - at - step * rate) for now, at, rate in zip(shapes[k][0], shapes[0][0], mode)) for k, step in ((1, 0.02), (2, 0.04))]
        self.assertLess(misses[1], 0.1 * 0.04 * largest, "the shape moves as the mode says")
        self.assertGreater(misses[1], 2.5 * misses[0], "what is left is of second order")
        other = self.numbers("api/felt/mode?j=1")
        self.assertGreater(max(abs(now - at - 0.04 * rate) for now, at, rate in zip(shapes[2][0], shapes[0][0], other)), 0.3 * 0.04 * largest, "control")
        rate = sum(a * b for a, b in zip(shapes[0][2], mode))
        self.assertAlmostEqual((shapes[2][1] - shapes[0][1]) / 0.04 / rate, 1, delta=0.1)
        self.assertEqual(self.studio.request("api/felt/mode?j=99")[0], 404)
        for old in (wish - 1, -1, "", "x", "99999999999"):
            self.assertEqual(self.studio.request(f"api/felt/shape?of={old}"), (200, b""), "another wish's shape is there now")
        envelope = self.numbers("api/felt/envelope")
        self.assertEqual(len(envelope), 2 * len(mode) // 3)
        self.assertGreaterEqual(min(envelope), 0)
        self.assertLessEqual(max(envelope), 0.04 * 1.001 * self.diagonal(), "never beyond the motion limit")
        for refused in ({"x": [1]}, {"level": 1, "x": ["a"]}, {"level": "1"}, {"level": -1}):
            status, answer = self.studio.post("feel", text=yaml, **refused)
            self.assertTrue(status == 409 or "error" in self.felt(answer["wish"])["answer"], refused)

    def diagonal(self):
        body = self.studio.request("api/surface")[1]
        return json.loads(body[4:4 + int.from_bytes(body[:4], "little")])["diagonal"]

    def test_newer_wishes_overtake_older_ones_and_hold_up_nothing(self):
        self.opened()
        yaml = ("surface: {file: body.stl}\nregions: {root: {plane: {normal: [1, 0, 0], at: 0.8}, side: below}}\nfixed: [root]\n"
                "objective: {maximize: volume}\nparameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 4%}\n")
        count = len(self.felt(self.studio.post("feel", text=yaml)[1]["wish"])["answer"]["variables"])
        begin, slowest, last = time.monotonic(), 0, 0
        for k in range(30):
            before = time.monotonic()
            last = self.studio.post("feel", text=yaml, level=1, x=[0.01 * k] + [0.0] * (count - 1))[1]["wish"]
            slowest = max(slowest, time.monotonic() - before)
        self.assertLess(slowest, 1, "a handler waits for no shape")
        answer = self.felt(last)["answer"]
        self.assertEqual(answer["status"], "ok")
        self.assertLess(time.monotonic() - begin, 15 * max(answer["seconds"], 0.1) + 2, "not thirty shapes")

    def test_forms_change_the_text_and_nothing_else(self):
        self.opened()
        yaml = "surface: {file: body.stl}  # mine\nobjective: {maximize: volume}\n"
        status, found = self.studio.post("set", text=yaml, values=[["optimize.budget.evaluations", "7"], ["surface.units", "mm"]])
        self.assertEqual(status, 200, found)
        self.assertEqual(found["text"], "surface: {file: body.stl, units: mm}  # mine\nobjective: {maximize: volume}\noptimize:\n  budget:\n    evaluations: 7\n")
        rows = {row["path"]: row for row in self.studio.post("form", text=found["text"])[1]["rows"]}
        self.assertEqual((rows["optimize.budget.evaluations"]["value"], rows["surface.units"]["value"]), ("7", "mm"))
        for values in ("x", [["a"]], [["a", 1]], [["a", "[1"]]):
            self.assertEqual(self.studio.post("set", text=yaml, values=values)[0], 409, values)

    def test_a_part_of_a_wing_is_what_check_counts(self):
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "3000", "-o", self.folder / "wing.stl"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup((self.folder / "wing.stl").unlink)
        with Studio(self.folder, "wing.stl") as studio:
            studio.until(lambda s: not s["is_opening"])
            steps = [{"wing": {"of": "", "chord": [0.15, 0.6], "span": [0.2, 0.9], "side": "upper"}}]
            yaml = "surface: {file: wing.stl}\nsymmetry: {plane: y, at: 0}\nobjective: {maximize: volume}\n"
            status, seen = studio.post("choose", text=yaml, steps=steps)
            self.assertEqual(status, 200, seen)
            status, made = studio.post("region", text=yaml, name="spars", steps=steps, fix=True)
            self.assertEqual(status, 200, made)
            self.assertIn("spars: {of: wing, chord: [0.15, 0.6], span: [0.2, 0.9], side: upper}", made["text"])
            self.assertIn("planform:\n  wing: {span: ", made["text"])
        (self.folder / "wing.yaml").write_text(made["text"])
        self.addCleanup((self.folder / "wing.yaml").unlink)
        checked = subprocess.run([STRAKE, "check", "wing.yaml", "--quick", "--json"], cwd=self.folder, capture_output=True, text=True, check=False)
        facts = json.loads(checked.stdout)
        count = next(r["triangles"] for r in facts["regions"] if r["name"] == "spars")
        self.assertEqual(count, seen["triangles"], checked.stdout[:500])
        self.assertGreater(count, 200)

    def test_a_fixed_region_takes_the_place_of_hold(self):
        self.opened()
        yaml = ("surface: {file: body.stl}\nhold: point      # or a place\nobjective: {maximize: volume}\n"
                "parameters: {levels: auto, variables: [normal], max_displacement: 4%}\n")
        steps = [{"op": "+", "plane": {"normal": [1, 0, 0], "at": 0.8, "above": False}}]
        moving = self.studio.post("region", text=yaml, name="tip", steps=steps, fix=False)[1]
        self.assertIn("hold: point", moving["text"])
        status, made = self.studio.post("region", text=yaml, name="root", steps=steps, fix=True)
        self.assertEqual((status, made["taken_out"]), (200, "hold: point"), made)
        self.assertNotIn("hold:", made["text"])
        file = self.folder / "held.yaml"
        self.addCleanup(file.unlink)
        for words, code in ((made["text"], 0), (made["text"] + "hold: point\n", 2)):
            file.write_text(words)
            checked = subprocess.run([STRAKE, "check", "held.yaml", "--quick"], cwd=self.folder, capture_output=True, text=True, check=False)
            self.assertEqual(checked.returncode == 0, code == 0, checked.stderr)

    def test_read_only(self):
        with Studio(self.folder, "body.stl", "--read-only") as studio:
            studio.until(lambda s: not s["is_opening"])
            before = sorted(self.folder.iterdir())
            for what in ("save", "propose", "full_check", "run", "stop", "resume"):
                status, answer = studio.post(what, name="x.yaml", text="surface: body.stl\n", mark="")
                self.assertEqual(status, 409)
                self.assertIn("read-only", answer["error"])
            status, answer = studio.post("region", text="surface: body.stl\n", name="x", steps=[{"triangles": [1, 500, 900]}])
            self.assertEqual(status, 409)
            self.assertEqual(sorted(self.folder.iterdir()), before)

    def test_runs_stops_and_resumes(self):
        self.opened()
        case = self.folder / "long.yaml"
        case.write_text("surface: {file: body.stl}\nregions: {root: {plane: {normal: [1, 0, 0], at: 0.8}, side: below}}\nfixed: [root]\n"
                        "objective: {maximize: volume}\nconstraints: {area: {max: 1.03, relative: true}}\n"
                        "parameters: {levels: auto, variables: [normal], max_displacement: 4%}\noptimize: {budget: {evaluations: 4000}}\n")
        self.addCleanup(case.unlink)
        self.studio.post("open", name="long.yaml")
        self.studio.until(lambda s: s["case"] == "long.yaml" and not s["is_opening"])
        status, made = self.studio.post("run")
        self.assertEqual(status, 200, made)
        running = self.studio.until(lambda s: s["run"] and len(s["run"]["rows"]) >= 2)
        self.assertEqual(running["run"]["status"], "running")
        self.assertEqual([row[0] for row in running["run"]["rows"]], list(range(1, len(running["run"]["rows"]) + 1)))
        self.assertEqual(self.studio.post("run")[0], 409, "one at a time")
        self.studio.process.kill()  # the studio's end is not the run's
        self.studio.process.wait()
        with Studio(self.folder, made["folder"]) as again:
            seen = again.until(lambda s: s["run"] and len(s["run"]["rows"]) > len(running["run"]["rows"]))
            self.assertEqual(seen["run"]["status"], "running")
            self.assertEqual(again.post("stop")[0], 200)
            again.until(lambda s: s["run"]["status"] == "interrupted")
        with Studio(self.folder, "long.yaml") as third:
            self.assertEqual(third.post("attach", name=made["folder"])[0], 200)
            stopped = third.until(lambda s: s["run"] and s["run"]["rows"])
            self.assertEqual(third.post("resume")[0], 200)
            third.until(lambda s: s["run"]["status"] == "running" and len(s["run"]["rows"]) > len(stopped["run"]["rows"]))
            third.post("stop")
            third.until(lambda s: s["run"]["status"] == "interrupted")

    def test_shows_how_the_solver_converges(self):
        self.opened()
        solver = ("import json, pathlib, time\nh = pathlib.Path('history.csv')\nwords = 'Iteration,rms[Rho]\\n'\n"
                  "for k in range(5):\n    words += f'{k},{-k / 2}\\n'\n    h.write_text(words)\n    time.sleep(0.1)\n"
                  "json.dump({'value': 1.0}, open('result.json', 'w'))\n")
        (self.folder / "solver.py").write_text(solver)
        (self.folder / "solved.yaml").write_text(
            "surface: {file: body.stl}\nregions: {root: {plane: {normal: [1, 0, 0], at: 0.8}, side: below}}\nfixed: [root]\n"
            "quantities: {drag: {command: [python3, '{case_dir}/solver.py'], gradients: false, convergence: history.csv}}\n"
            "objective: {minimize: drag}\nparameters: {levels: auto, patches_per_level: [4], variables: [normal], max_displacement: 1%}\n"
            "optimize: {method: cobyla, budget: {evaluations: 2}}\n")
        self.assertEqual(self.studio.post("open", name="solved.yaml")[0], 200)
        self.studio.until(lambda s: s["case"] == "solved.yaml" and not s["is_opening"])
        status, made = self.studio.post("run")
        self.assertEqual(status, 200, made)
        at_work = self.studio.until(lambda s: s["run"] and s["run"].get("has_convergence"))
        self.assertTrue(at_work["run"]["has_convergence"])
        def table(query=""):
            return json.loads(self.studio.request(f"api/convergence{query}")[1])
        end = time.monotonic() + 30
        while not table()["names"] and time.monotonic() < end:
            time.sleep(0.02)
        self.studio.until(lambda s: s["run"]["status"] not in ("running", "starting"))
        found = table()
        self.assertEqual([f["evaluation"] for f in found["files"]], [2, 1])
        self.assertEqual((found["shown"], found["names"]), ("000002/history.csv", ["Iteration", "rms[Rho]"]))
        self.assertEqual(found["columns"], [[0, 1, 2, 3, 4], [0, -0.5, -1, -1.5, -2]])
        self.assertEqual(table("?name=000001/history.csv")["shown"], "000001/history.csv")
        self.assertEqual(table("?name=../../secret.yaml")["shown"], "000002/history.csv", "only names of its own list")
        run = self.folder / made["folder"]
        (run / "evaluations/000002/history.csv").unlink()
        os.symlink(self.outside / "secret.yaml", run / "evaluations/000002/history.csv")
        self.assertEqual([f["evaluation"] for f in table()["files"]], [1], "a link out of the folder is not followed")
        # A run that lies elsewhere, a shape and a report that do.
        elsewhere = self.outside / "elsewhere"
        shutil.copytree(run, elsewhere)
        os.symlink(elsewhere, self.folder / "runs" / "linked")
        self.addCleanup((self.folder / "runs" / "linked").unlink)
        self.assertNotIn("runs/linked", json.loads(self.studio.request("api/files")[1])["runs"])
        self.assertNotIn("runs/linked", [d["run"] for d in json.loads(self.studio.request("api/designs")[1])["designs"]])
        for name in ("report.html", "best.stl"):
            (run / name).unlink(missing_ok=True)
            os.symlink(self.outside / "secret.stl", run / name)
        self.assertEqual(self.studio.request("report")[0], 404)
        self.assertEqual(self.studio.request("api/best")[0], 404)

    def test_knows_every_key_of_a_case(self):
        status, body = self.studio.request("api/keys")
        self.assertEqual(status, 200)
        keys = {key["path"]: key for key in json.loads(body)}
        self.assertIn("sqp", keys["optimize.method"]["words"])
        self.assertTrue(keys["optimize.finite_differences"]["is_flag"])
        self.assertIn("regions.*.box", keys)
        self.assertTrue(all(key["doc"] and key["form"] for path, key in keys.items() if path != ""), [p for p, k in keys.items() if not k["doc"]][:5])

    def test_run_shows_itself(self):
        case = self.folder / "shown.yaml"
        case.write_text("surface: {file: body.stl}\nregions: {root: {plane: {normal: [1, 0, 0], at: 0.8}, side: below}}\nfixed: [root]\n"
                        "objective: {maximize: volume}\nconstraints: {area: {max: 1.03, relative: true}}\n"
                        "parameters: {levels: auto, variables: [normal], max_displacement: 4%}\noptimize: {budget: {evaluations: 4000}}\n"
                        "output: {dir: in_the_case}\n")
        self.addCleanup(case.unlink)
        environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
        few = ["--set", "optimize.budget.evaluations=6"]

        def run(*arguments):
            studio = Studio(self.folder, command=[STRAKE, "run", "shown.yaml", *arguments, "--studio"], environment=environment)
            self.addCleanup(studio.process.stdout.close)
            self.addCleanup(studio.process.stderr.close)
            return studio
        alone = subprocess.run([STRAKE, "run", "shown.yaml", *few, "--out", "alone", "-q"], cwd=self.folder, capture_output=True, check=False)
        shown = run(*few, "--out", "beside")
        seen = shown.until(lambda s: s["run"] and s["run"]["status"] not in ("running", "starting"))
        self.assertEqual(len(seen["run"]["rows"]), 6)
        self.assertEqual(pathlib.Path(seen["run"]["folder"]), (self.folder / "beside").resolve())
        told = ""
        while "the run has ended" not in told:  # its last evaluation is not yet its end
            line = shown.process.stderr.readline()
            self.assertTrue(line, told)
            told += line
        self.assertIsNone(shown.process.poll(), "the page stays")
        code, _, err = shown.end(signal.SIGINT)
        self.assertEqual(code, alone.returncode, told + err)
        self.assertEqual((self.folder / "beside/best.stl").read_bytes(), (self.folder / "alone/best.stl").read_bytes(), "the same bits")
        stopped = run()
        stopped.until(lambda s: s["run"] and len(s["run"]["rows"]) >= 2)
        code, _, err = stopped.end(signal.SIGINT)
        self.assertNotEqual(code, 0, err)
        status = subprocess.run([STRAKE, "status", "in_the_case", "--json"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertEqual(json.loads(status.stdout)["status"], "interrupted", "in the case's own folder, and it can be resumed")
        for arguments, words in ((["--set", "optimize.budget.evaluation=3"], "evaluation"), ([], "in_the_case"), (["--json"], "--json")):
            ended = subprocess.run([STRAKE, "run", "shown.yaml", *arguments, "--studio"], cwd=self.folder, capture_output=True, text=True, timeout=30,
                                   env=environment, check=False)
            self.assertNotEqual(ended.returncode, 0, words)
            self.assertEqual(ended.stdout, "", "no page")
            self.assertIn(words, ended.stderr)

    def test_ends_in_order_and_is_quiet(self):
        self.opened()
        time.sleep(1)
        before = pathlib.Path(f"/proc/{self.studio.process.pid}/stat").read_text().split()
        time.sleep(1)
        after = pathlib.Path(f"/proc/{self.studio.process.pid}/stat").read_text().split()
        self.assertLessEqual(int(after[13]) + int(after[14]) - int(before[13]) - int(before[14]), 3, "ticks of 10 ms without a page")
        self.assertEqual(self.studio.end(signal.SIGINT), (0, "", ""))
        with self.assertRaises(ConnectionRefusedError):
            self.studio.request("")

    def test_ends_at_once_while_it_reads_a_file(self):
        large = self.folder / "large.stl"  # ten seconds or more
        self.addCleanup(large.unlink)
        subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1000000", "-o", large], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        slow = Studio(self.folder, "large.stl", "--new-address")
        self.addCleanup(slow.process.stdout.close)
        self.addCleanup(slow.process.stderr.close)
        self.assertTrue(slow.state()["is_opening"])
        before = os.times()
        self.assertEqual(slow.end(signal.SIGTERM)[0], 0)
        after = os.times()
        self.assertLess(after.children_user - before.children_user, 2, "seconds of CPU of all that it did")

    def test_says_what_cannot_be(self):
        for arguments, words in ((["nowhere.stl"], "nowhere.stl"), (["body.stl", "--port", str(self.studio.port)], "port")):
            ended = subprocess.run([STRAKE, "studio", *arguments, "--no-browser"], cwd=self.folder, capture_output=True, text=True,
                                   timeout=20, check=False)
            self.assertNotEqual(ended.returncode, 0)
            self.assertEqual(ended.stdout, "")
            self.assertIn(words, ended.stderr)
        self.opened()
        with Studio(self.folder, environment={**os.environ, "SSH_CONNECTION": "1 2 3 4"}) as second:
            err = second.end(signal.SIGTERM)[2]
            self.assertIn("another studio is open", err)
            self.assertIn(f"ssh -L {second.port}:127.0.0.1:{second.port}", err)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
