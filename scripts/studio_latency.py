#!/usr/bin/env python3
"""How long a slider of strake studio takes: studio_latency.py STRAKE CASE [MOVES [PRIORITY]]

Medians over MOVES (default 15) moves by 5 % of a variable's range, in a headless Chromium with software rendering: from the event to the
drawn first-order shape, to the drawn exact shape, to the guard's verdict and the values, and of a frame alone, with smooth and with
rough edges. "Processor" is the time of all threads of the studio for one move: beside other work, of which the load tells, the
clock runs faster than that. PRIORITY, as of nice and root's if negative, is given to the studio and to the browser for the measurement.
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
priority = int(sys.argv[4]) if len(sys.argv) > 4 else 0
state = "document.documentElement.dataset"
# gl.finish() only flushes in Chromium; a pixel that is read back is there.
drawn = "(() => { const g = strakeStudio.scene.viewer.renderer.getContext(); g.readPixels(0, 0, 1, 1, g.RGBA, g.UNSIGNED_BYTE, new Uint8Array(4)); })()"


def status_of(pid):
    return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()


def family_of(root):
    """The process and those that it started."""
    parents = {}
    for pid in (int(p.name) for p in pathlib.Path("/proc").iterdir() if p.name.isdigit()):
        try:
            parents[pid] = int(status_of(pid)[1])
        except OSError:  # it has ended meanwhile
            pass
    family = {root}
    while more := {pid for pid, parent in parents.items() if parent in family} - family:
        family |= more
    return family


def processor(process):
    words = [status_of(pid) for pid in family_of(process.pid)]
    return sum(int(one[11]) + int(one[12]) for one in words) / os.sysconf("SC_CLK_TCK")


def prefer(root):
    """Gives the priority to every thread of a process and of those that it started."""
    for pid in family_of(root):
        try:
            for thread in os.listdir(f"/proc/{pid}/task"):
                os.setpriority(os.PRIO_PROCESS, int(thread), priority)
        except (FileNotFoundError, ProcessLookupError):
            pass


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
        b.run("(() => { const f = strakeStudio.feel, note = f.note.bind(f); f.note = (kind, begin) => { if (kind !== 'judged') DRAWN; note(kind, begin); }; })()"
              .replace("DRAWN", drawn))
        for k in range(moves + 1):  # the first one warms up
            if k == 1:
                b.until("strakeStudio.feel.hasEnvelope", 600)  # all modes are there, and nothing else is at work
                b.until("strakeStudio.feel.modes.size >= Math.min(strakeStudio.feel.list.length, strakeStudio.feel.numModes)", 60)
                b.run("Object.keys(strakeStudio.feel.times).forEach((kind) => { strakeStudio.feel.times[kind] = []; })")
                if priority:
                    prefer(studio.pid)
                    prefer(b.process.pid)
                before = processor(studio)
            share = (0.05, 0.15, 0.25, 0.15)[k % 4]  # of half the range: 5 % of the range each time
            b.run(f"(() => {{ const i = document.querySelector('.slider input'); i.value = {share} * i.max; i.dispatchEvent(new Event('input')); "
                  "if (!strakeStudio.feel.modes.get(0)) throw new Error('no mode'); })()")
            time.sleep(0.05)
            b.until(f"{state}.felt.startsWith('ok') || {state}.felt === 'error'", 300)
            b.until("!strakeStudio.scene.viewer.isRough", 20)
            b.run(drawn)  # what was asked to be drawn is drawn: a slider is taken when the page rests
        used = (processor(studio) - before) / moves
        times = b.run("strakeStudio.feel.times")
        frames = {kind: b.run("""(async () => { const v = strakeStudio.scene.viewer, list = [];
            for (let k = 0; k < 15; ++k) { v.camera.position.applyAxisAngle(v.camera.up, 0.05); v.controls.update(); const t = performance.now(); v.hurriedUntil = UNTIL; v.render(); DRAWN;
              list.push(performance.now() - t); await new Promise((done) => setTimeout(done, 20)); } return list; })()""".replace("DRAWN", drawn).replace("UNTIL", until))
            for kind, until in (("smooth", "0"), ("rough", "t + 1000"))}
        script = b.run("""(() => { const f = strakeStudio.feel, list = []; for (let k = 0; k < 9; ++k) { f.x[0] += 1e-4; const t = performance.now(); f.preview(); list.push(performance.now() - t); } return list; })()""")
        dragged, before = 20, processor(b.process)
        b.run(f"""(async () => {{ const f = strakeStudio.feel, v = strakeStudio.scene.viewer; for (let k = 0; k < {dragged}; ++k) {{ f.x[0] += 1e-4; f.preview(); v.render(); DRAWN; }} }})()""".replace("DRAWN", drawn))
        per_frame = (processor(b.process) - before) / dragged
        size = b.run("strakeStudio.scene.body.count")
        word = lambda values: f"{statistics.median(values):.0f} ms ({min(values):.0f} to {max(values):.0f})" if values else "none"
        print(f"{size} triangles, load {os.getloadavg()[0]:.1f}: first order on the screen {word(times['preview'])}, of it script {word(script)}; "
              f"exact on the screen {word(times['exact'])}; guard and values {word(times['judged'])}; processor {1000 * used:.0f} ms, the browser's for a first-order frame {1000 * per_frame:.0f} ms; "
              f"a frame {word(frames['smooth'])}, rough {word(frames['rough'])}")
finally:
    studio.send_signal(signal.SIGTERM)
    studio.communicate()
    cache.cleanup()
