"""What a run shows: a bar on a terminal, plain lines elsewhere; `status --watch` follows it. Argument: the program."""
import fcntl
import os
import pathlib
import pty
import re
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time

STRAKE = str(pathlib.Path(sys.argv[1]).resolve())
sys.dont_write_bytecode = True
sys.argv[1:] = [STRAKE]
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from mistakes_test import BODY, body, case, obj, program  # noqa: E402

failures = []
WIDTH = 90


def expect(is_so, words):
    if not is_so:
        failures.append(words)


def slow_folder(where, evaluations=8):
    folder = pathlib.Path(where)
    files = program(r"""sleep 0.1; awk '/^v/ {s += $3 * $3} END {printf "{\"value\": %.9f}", s}' "$2" > "$1" """)
    files["case.yaml"] = files["case.yaml"].replace('"{result}"]', '"{result}", "{surface}"]')
    files["case.yaml"] = files["case.yaml"].replace("evaluations: 2", "evaluations: %d" % evaluations)
    files["body.obj"] = BODY
    for name, text in files.items():
        (folder / name).write_text(text)
    (folder / "solver.sh").chmod(0o755)
    return folder


def on_terminal(arguments, folder, which, **environment):
    """Runs with stdout or stderr on a terminal of WIDTH columns: what came there, and the rest."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, WIDTH, 0, 0))
    other = tempfile.TemporaryFile()
    streams = {"stdout": other, "stderr": other, which: theirs}
    child = subprocess.Popen([STRAKE, *arguments], cwd=folder, stdin=subprocess.DEVNULL,
                             env={**os.environ, "TERM": "xterm", **environment}, **streams)
    os.close(theirs)
    seen = b""
    while True:
        try:
            more = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not more:
            break
        seen += more
    status = child.wait(timeout=60)
    other.seek(0)
    return status, seen.decode(), other.read().decode()


def bar_on_a_terminal():
    with tempfile.TemporaryDirectory() as where:
        folder = slow_folder(where)
        status, seen, out = on_terminal(["run", "case.yaml", "--out", "runs"], folder, "stderr")
        expect(status == 0, "status %d\n%s" % (status, seen))
        drawn = re.findall(r"\r(\[[^\x1b]*)\x1b\[K", seen)
        expect(len(drawn) >= 6, "%d bars in %r" % (len(drawn), seen))
        expect(max(map(len, drawn), default=0) < WIDTH, "longer than the terminal: %r" % max(drawn, key=len, default=""))
        last = drawn[-1] if drawn else ""
        evaluations = len(re.findall(r"^ +1 +\d+ +\d+ +\d+  ", seen.replace("\x1b[K", "\n"), re.M))
        for part in ("%d/8" % evaluations, "level 1", "best "):
            expect(part in last, "no '%s' in %r" % (part, last))
        expect(any(re.search(r"at most [0-9.]+ s left", d) for d in drawn), "no time left in %r" % drawn)
        # No promise before three evaluations are known.
        expect(not any("left" in d for d in drawn if re.search(r" [0-2]/8 ", d)), "a promise too early: %r" % drawn)
        expect(seen.rstrip("\r\n").endswith("\x1b[K") or "\r\x1b[K" in seen, "the bar stays: %r" % seen[-200:])
        expect("\x1b" not in out and "\r" not in out, "standard output: %r" % out)


def plain_elsewhere():
    with tempfile.TemporaryDirectory() as where:
        folder = slow_folder(where, 3)
        done = subprocess.run([STRAKE, "run", "case.yaml", "--out", "a"], cwd=folder, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True)
        expect("\r" not in done.stderr and "\x1b" not in done.stderr, "a log with %r" % done.stderr)
        expect(len(re.findall(r"^ +1 +\d+ +\d+ +\d+ ", done.stderr, re.M)) == 3, "a line an evaluation: %s" % done.stderr)
        _, seen, _ = on_terminal(["run", "case.yaml", "--out", "b"], folder, "stderr", TERM="dumb")
        expect("\x1b" not in seen and "[#" not in seen, "a dumb terminal gets %r" % seen)
        _, seen, _ = on_terminal(["run", "case.yaml", "-q", "--out", "c"], folder, "stderr")
        expect("[#" not in seen, "quiet: %r" % seen)


def watched():
    with tempfile.TemporaryDirectory() as where:
        folder = slow_folder(where, 12)
        child = subprocess.Popen([STRAKE, "run", "case.yaml", "-q", "--out", "runs"], cwd=folder,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for _ in range(200):
            if (folder / "runs/journal.sqlite").exists():
                break
            time.sleep(0.02)
        time.sleep(0.1)
        log = subprocess.run([STRAKE, "status", "runs", "--watch", "--every", "0.1"], cwd=folder, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, timeout=60)
        child.wait()
        lines = log.stdout.splitlines()
        expect(log.returncode == 0, "status %d: %s" % (log.returncode, log.stderr))
        expect(sum("/12" in line and line.startswith("[") for line in lines) >= 3, "followed: %s" % log.stdout)
        expect("status       " in log.stdout and "running" not in lines[-3], "the end: %s" % log.stdout)
        expect("\x1b" not in log.stdout and len(set(lines)) == len(lines), "a log: %r" % log.stdout)
        _, seen, _ = on_terminal(["status", "runs", "--watch"], folder, "stdout")
        expect("status       " in seen, "of a run that has ended: %r" % seen)


def the_limit_is_the_whole_one():
    """Of a run that went on for one more, the limit is told in all, not what the last level had of it."""
    with tempfile.TemporaryDirectory() as where:
        folder = pathlib.Path(where)
        (folder / "body.obj").write_text(BODY)
        (folder / "case.yaml").write_text(case(("patches_per_level: [2]", "patches_per_level: [2, 6]"), ("evaluations: 2", "evaluations: 4")))
        subprocess.run([STRAKE, "run", "case.yaml", "-q", "--out", "runs"], cwd=folder, stdout=subprocess.DEVNULL, check=True)
        more = subprocess.run([STRAKE, "resume", "runs", "-q", "--evaluations", "+1"], cwd=folder, stdout=subprocess.PIPE, text=True)
        expect("evaluations is reached (5)" in more.stdout, more.stdout)


def a_repair_is_interrupted():
    with tempfile.TemporaryDirectory() as where:
        folder = pathlib.Path(where)
        (folder / "large.obj").write_text(obj(*body(150, 300)))
        child = subprocess.Popen([STRAKE, "repair", "large.obj", "-o", "new.obj", "--all"], cwd=folder,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(0.2)
        ended = child.poll()
        child.send_signal(signal.SIGINT)
        _, words = child.communicate(timeout=60)
        if ended is None and child.returncode != 0:  # a fast machine may be done
            expect(child.returncode == 75 and "nothing was written" in words, "%d: %s" % (child.returncode, words))
            expect(not (folder / "new.obj").exists() and len(list(folder.iterdir())) == 1, "it has left something")


bar_on_a_terminal()
plain_elsewhere()
the_limit_is_the_whole_one()
a_repair_is_interrupted()
watched()
print("\n".join(failures) or "passed")
sys.exit(1 if failures else 0)
