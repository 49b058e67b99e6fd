#!/usr/bin/env python3
"""A page whose connection is lost for a minute, and a browser that is killed: lost_connection_test.py STRAKE MAKE_SURFACE. Exit status 77: skipped, with the reason.

Between the page and the studio is a tunnel, as ssh's, that dies without a word and comes back: what is sent meanwhile goes nowhere.
"""
import csv
import os
import pathlib
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from browser import Browser, find_chromium  # noqa: E402
from studio_at_work import Studio  # noqa: E402

STRAKE, MAKE_SURFACE = sys.argv[1:3]
SECONDS = 60


class Tunnel:
    """From [::1] to 127.0.0.1, same port."""

    def __init__(self, port):
        self.port, self.is_dead, self.is_over = port, False, False
        self.listens = socket.create_server(("::1", port), family=socket.AF_INET6)
        self.places = selectors.DefaultSelector()
        self.places.register(self.listens, selectors.EVENT_READ)
        self.others = {}
        self.work = threading.Thread(target=self.forward)
        self.work.start()

    def forward(self):
        while not self.is_over:
            if self.is_dead:
                time.sleep(0.05)
                continue
            for key, _ in self.places.select(0.05):
                if key.fileobj is self.listens:
                    near, _ = self.listens.accept()
                    far = socket.create_connection(("127.0.0.1", self.port))
                    self.others.update({near: far, far: near})
                    for one in (near, far):
                        self.places.register(one, selectors.EVENT_READ)
                elif key.fileobj in self.others and not self.pass_on(key.fileobj):
                    self.drop(key.fileobj)

    def pass_on(self, one):
        try:
            piece = one.recv(1 << 16)
            if piece:
                self.others[one].sendall(piece)
        except OSError:
            return False
        return bool(piece)

    def drop(self, one):
        for end in (one, self.others[one]):
            self.places.unregister(end)
            del self.others[end]
            end.close()

    def lose(self):
        self.is_dead = True

    def come_back(self):
        """What was under way is gone."""
        time.sleep(0.1)
        while self.others:
            self.drop(next(iter(self.others)))
        self.is_dead = False

    def close(self):
        self.is_over = True
        self.work.join()
        while self.others:
            self.drop(next(iter(self.others)))
        self.listens.close()


class LostConnection(unittest.TestCase):
    def test_a_run_goes_on_and_the_page_finds_its_way_back(self):
        around = tempfile.TemporaryDirectory()
        self.addCleanup(around.cleanup)
        folder = pathlib.Path(around.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "2000", "-o", folder / "body.stl"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        (folder / "solver.py").write_text(
            "import json, struct, time\ntime.sleep(0.5)\ndata = open('surface.stl', 'rb').read()\ncount, = struct.unpack_from('<I', data, 80)\n"
            "heights = [struct.unpack_from('<f', data, 104 + 50 * t)[0] for t in range(count)]\n"
            "json.dump({'value': sum(h * h for h in heights)}, open('result.json', 'w'))\n")
        (folder / "case.yaml").write_text(
            "surface: {file: body.stl}\nregions: {root: {plane: {normal: [1, 0, 0], at: 0.8}, side: below}}\nfixed: [root]\n"
            "objective: {minimize: drag}\nquantities: {drag: {command: [python3, '{case_dir}/solver.py'], gradients: false}}\n"
            "parameters: {levels: auto, fields: none, variables: [normal], max_displacement: 4%}\n"
            "optimize: {budget: {evaluations: 400}}\noutput: {dir: a_run}\n")
        studio = self.enterContext(Studio(STRAKE, folder, "case.yaml"))
        tunnel = Tunnel(studio.port)
        self.addCleanup(tunnel.close)
        address = studio.url.strip().replace("127.0.0.1", "localhost")
        rows = "strakeStudio.runs.rows.length"

        def opened():
            browser = Browser(1280, 860, ["--host-resolver-rules=MAP localhost [::1]"])
            browser.open(address)
            browser.until("document.documentElement.dataset.ready > 0")
            browser.click("#tab-run")
            return browser
        b = opened()
        self.addCleanup(b.__exit__)
        b.click("#start")
        b.until(f"{rows} > 1", 60)
        tunnel.lose()
        lost, before = time.monotonic(), b.run(rows)
        b.until("strakeStudio.isLost", 40)
        self.assertIn("does not answer", b.run("document.querySelector('.told').innerText"))
        self.assertIn("goes on", b.run("document.querySelector('.told').innerText"))
        time.sleep(max(0.0, lost + SECONDS - time.monotonic()))
        self.assertLessEqual(b.run(rows), before + 1, "nothing came through")
        tunnel.come_back()
        b.until("!strakeStudio.isLost", 30)
        self.assertEqual(b.run("document.querySelector('.told').innerText"), "")
        b.until(f"{rows} > {before + SECONDS // 4}", 30)

        os.killpg(b.process.pid, signal.SIGKILL)
        seen = len(studio.state()["run"]["rows"])
        studio.until(lambda s: len(s["run"]["rows"]) > seen + 2)
        with opened() as again:
            again.until(f"{rows} > {seen + 2}", 30)
            again.click("#stop")
            again.until("!['running', 'starting'].includes(document.documentElement.dataset.run)", 60)
            with open(next(folder.rglob("history.csv")), encoding="utf-8") as lines:
                written = [int(row["evaluation"]) for row in csv.DictReader(lines)]
            again.until(f"{rows} === {len(written)}", 20)
            self.assertEqual(again.run("strakeStudio.runs.rows.map((r) => r[0])"), written, "each evaluation once, in order")
        self.assertEqual(studio.state()["run"]["status"], "interrupted", "it can be resumed")

    def test_a_connection_that_is_lost_while_something_opens(self):
        """The page asks again for what did not come, whatever it was."""
        around = tempfile.TemporaryDirectory()
        self.addCleanup(around.cleanup)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "2000", "-o", pathlib.Path(around.name) / "body.stl"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with Studio(STRAKE, around.name, "body.stl") as studio, Browser(1280, 860) as b:
            b.open(studio.url.strip())
            b.until("document.documentElement.dataset.ready > 0")
            b.run("(() => { const ask = window.fetch; window.asked = {}; window.fetch = (path, how) => { const name = String(path).split('?')[0]; window.asked[name] = (window.asked[name] || 0) + 1; "
                  "return window.lost === name && window.asked[name] === 1 ? Promise.reject(new TypeError('lost')) : ask(path, how); }; })()")
            for lost in ("api/case", "api/files", "api/surface"):
                b.run(f"window.asked = {{}}; window.lost = '{lost}'; strakeStudio.version = -1")
                b.until(f"window.asked['{lost}'] > 1 && window.asked['api/surface'] > 0 && !strakeStudio.isLost", 20)
                b.until("document.querySelector('.told').innerText === ''", 20)
            self.assertEqual(b.errors, [])


if __name__ == "__main__":
    if not find_chromium():
        print("skipped: there is no chromium")
        sys.exit(77)
    signal.alarm(400)
    unittest.main(argv=sys.argv[:1])
