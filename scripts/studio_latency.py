#!/usr/bin/env python3
"""How long a slider of strake studio takes: studio_latency.py STRAKE CASE [MOVES]

Medians over MOVES (default 15) moves by 5 % of a variable's range, in a headless Chromium with software rendering: from the event to
the drawn first-order shape, to the exact shape with the guard's verdict and the values, and of the drawing alone. The exact shape and the
values come in one answer. "Processor" is the time of all threads of the studio for one move: beside other work, of which the load tells, the
clock runs faster than that.
"""
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from browser import Browser  # noqa: E402

strake, case = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
moves = int(sys.argv[3]) if len(sys.argv) > 3 else 15
state = "document.documentElement.dataset"
# gl.finish() only flushes in Chromium; a pixel that is read back is there.
drawn = "(() => { const g = strakeStudio.scene.viewer.renderer.getContext(); g.readPixels(0, 0, 1, 1, g.RGBA, g.UNSIGNED_BYTE, new Uint8Array(4)); })()"


def processor(process):
    words = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


cache = tempfile.TemporaryDirectory()
os.environ["XDG_CACHE_HOME"] = cache.name
studio = subprocess.Popen([strake, "studio", case.name, "--no-browser"], cwd=case.parent, stdout=subprocess.PIPE, text=True)
try:
    with Browser(1280, 860) as b:
        b.open(studio.stdout.readline().strip())
        b.until(f"{state}.ready > 0", 300)
        b.click("#tab-feel")
        b.until(f"({state}.felt || '').startsWith('ok')", 600)
        b.until(f"{state}.fetched > 0", 600)
        for k in range(moves + 1):  # the first one warms up
            if k == 1:
                b.run("strakeStudio.feel.times = { preview: [], exact: [] }")
                b.until("strakeStudio.feel.hasEnvelope", 600)  # all modes are there, and nothing else is at work
                before = processor(studio)
            share = 0.1 * (k % 4 - 1)
            b.run("(() => { const i = document.querySelector('.slider input'), v = strakeStudio.scene.viewer, t = performance.now(); "
                  f"i.value = {share} * i.max; i.dispatchEvent(new Event('input')); "
                  "v.afterDraw = () => { " + drawn + "; strakeStudio.feel.note('preview', performance.now() - t); "
                  "if (!strakeStudio.feel.modes.get(0)) throw new Error('no mode'); }; })()")
            time.sleep(0.05)
            b.until(f"{state}.felt.startsWith('ok') || {state}.felt === 'error'", 300)
        used = (processor(studio) - before) / moves
        times = b.run("strakeStudio.feel.times")
        frames = b.run("""(async () => { const v = strakeStudio.scene.viewer, list = [];
            for (let k = 0; k < 15; ++k) { const t = performance.now(); v.camera.position.applyAxisAngle(v.camera.up, 0.05); v.controls.update(); v.render(); DRAWN;
              list.push(performance.now() - t); await new Promise((done) => setTimeout(done, 20)); } return list; })()""".replace("DRAWN", drawn))
        script = b.run("""(() => { const f = strakeStudio.feel, list = []; for (let k = 0; k < 9; ++k) { f.x[0] += 1e-4; const t = performance.now(); f.preview(); list.push(performance.now() - t); } return list; })()""")
        size = b.run("strakeStudio.scene.body.count")
        word = lambda values: f"{statistics.median(values):.0f} ms ({min(values):.0f} to {max(values):.0f})" if values else "none"
        print(f"{size} triangles, load {os.getloadavg()[0]:.1f}: preview on the screen {word(times['preview'])}, of it script {word(script)}; "
              f"exact shape, guard and values {word(times['exact'])}, processor {1000 * used:.0f} ms; a frame {word(frames)}")
finally:
    studio.send_signal(signal.SIGTERM)
    studio.communicate()
    cache.cleanup()
