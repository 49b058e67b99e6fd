#!/usr/bin/python3
"""A thousand programs at a time: thousand_places.py OUT [--bin FOLDER] [--places N] [--designs N] [--seconds S]
OUT is a new folder, or an empty one.

A sample of 5 000 designs (60 fields, a body of 1 500 triangles) by a program that sleeps for 30 seconds, a thousand at a time. Each call notes when it
began and ended. Prints what share of the places was busy from the moment when all were filled to the last start, and until places become empty for want of
designs; CPU and memory of strake itself; the size of its journal. Ends with the exit status of strake.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = """#!/bin/sh
begun=$(cat /proc/uptime)
sleep {seconds}
echo "$begun $(cat /proc/uptime)" >> "{log}/$$"
echo '{{"value": 1}}' > "$1"
"""
CASE = """case: thousand_places
surface: {{file: body.stl, units: m}}
shell: none
parameters: {{fields: 60, variables: [], max_displacement: 1%}}
quantities:
  cost: {{command: [./program.sh, "{{result}}"], gradients: false, parallel: {places}, timeout: 1h}}
objective: {{minimize: cost}}
output: {{keep: none}}
"""


def read_calls(folder):
    """(begin, end) of each call. A file holds those of one process id, which may be several."""
    rows = [line.split() for file in folder.iterdir() for line in file.read_text(encoding="ascii").splitlines()]
    return [(float(words[0]), float(words[2])) for words in rows]


def filled_at(calls, places):
    """When `places` are running for the first time; None: never."""
    running = 0
    for at, change in sorted([(begin, 1) for begin, _ in calls] + [(end, -1) for _, end in calls]):
        running += change
        if running == places:
            return at
    return None


def busy_share(calls, places, since, until):
    return sum(max(0.0, min(end, until) - max(begin, since)) for begin, end in calls) / places / (until - since)


def busy_words(calls, places):
    filled = filled_at(calls, places)
    if filled is None:
        return f"the {places} places were never all filled; raise --seconds"
    last_start, last_full = max(begin for begin, _ in calls), sorted(end for _, end in calls)[-places]
    if filled >= min(last_start, last_full):
        return f"the {places} places were not filled before the last start; raise --designs or --seconds"
    return (f"places filled after {filled - min(begin for begin, _ in calls):.1f} s; "
            f"busy to the last start {100 * busy_share(calls, places, filled, last_start):.1f} %, "
            f"to the first end after it {100 * busy_share(calls, places, filled, last_full):.1f} %")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/programs", help="folder of strake and make_surface")
    parser.add_argument("--places", type=int, default=1000)
    parser.add_argument("--designs", type=int, default=5000)
    parser.add_argument("--seconds", type=float, default=30)
    options = parser.parse_args()
    if options.designs <= options.places:
        parser.error(f"--designs {options.designs} must be > --places {options.places}: with fewer, the places are never all filled")
    out = options.out.resolve()
    if out.is_file() or out.is_dir() and any(out.iterdir()):
        parser.error(f"{out}: exists and is not an empty folder; give a new one")
    (out / "log").mkdir(parents=True)
    (out / "program.sh").write_text(PROGRAM.format(seconds=options.seconds, log=out / "log"), encoding="utf-8")
    (out / "program.sh").chmod(0o755)
    (out / "case.yaml").write_text(CASE.format(places=options.places), encoding="utf-8")
    subprocess.run([options.bin / "make_surface", "lifting_body", "--triangles", "1500", "-o", out / "body.stl"], check=True, stdout=subprocess.DEVNULL)
    began = time.monotonic()
    strake = subprocess.Popen([options.bin / "strake", "sample", out / "case.yaml", "-n", str(options.designs), "--out", out / "run", "-q"])
    seen = {"cpu": 0.0, "kB": 0}

    def watch():
        while strake.poll() is None:
            try:
                fields = pathlib.Path(f"/proc/{strake.pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
                seen["cpu"] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")  # without those of the programs
                for line in pathlib.Path(f"/proc/{strake.pid}/status").read_text(encoding="ascii").splitlines():
                    if line.startswith("VmHWM"):
                        seen["kB"] = int(line.split()[1])
            except (OSError, IndexError):
                return
            time.sleep(0.5)

    watcher = threading.Thread(target=watch)
    watcher.start()
    code = strake.wait()
    watcher.join()
    wall = time.monotonic() - began
    calls = read_calls(out / "log")
    print(f"status {code}, {len(calls)} calls, {wall:.0f} s, {options.designs / options.places * options.seconds:.0f} at least")
    if code == 0:
        print(busy_words(calls, options.places))
    print(f"strake: {seen['cpu'] / wall:.2f} of a core, {seen['kB'] / 1024:.0f} MB; journal {sum(f.stat().st_size for f in (out / 'run').glob('journal*')) / 1e6:.1f} MB")
    return code


if __name__ == "__main__":
    sys.exit(main())
