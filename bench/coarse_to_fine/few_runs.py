#!/usr/bin/env python3
"""What 20 to 200 evaluations buy: table of the evidence suite for few evaluations.

few_runs.py FOLDER...   reads *-trace.csv of strake_evidence in each FOLDER and prints, for every problem and way, the
decrease after 20, 50, 100 and 200 evaluations in percent of the largest that any way in the folder reached, then for
each way on how many problems it is the best (or within 5 % of the best), and medians.
"""

import csv
import glob
import math
import os
import statistics
import sys

COUNTS = (20, 50, 100, 200)


def traces(folder):
    """Best feasible objective by evaluation, for each (problem, solver, method)."""
    found = {}
    for path in sorted(glob.glob(os.path.join(folder, "*-trace.csv"))):
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                key = row["problem"], row["solver"], row["method"]
                found.setdefault(key, []).append(float(row["best"]))
    return found


def gain(trace, start, count):
    known = [v for v in trace[:count] if not math.isnan(v)]
    return start - known[-1] if known and not math.isnan(start) else 0.0


def main(folders):
    shares = {}  # (folder, problem): {way: [share at each count]}
    for folder in folders:
        all_traces = traces(folder)
        for problem in dict.fromkeys(key[0] for key in all_traces):
            of = {key[1:]: t for key, t in all_traces.items() if key[0] == problem}
            start = next(t[0] for t in of.values() if not math.isnan(t[0]))
            best = max(gain(t, start, len(t)) for t in of.values())
            shares[folder, problem] = {
                way: [100 * gain(t, start, c) / best if best > 0 else 0 for c in COUNTS] for way, t in of.items()}
    ways = list(dict.fromkeys(way for row in shares.values() for way in row))
    print("| set, problem |" + "".join(f" {s} {m} |" for s, m in ways))
    print("|---|" + "---|" * len(ways))
    for (folder, problem), row in shares.items():
        cells = (" / ".join(f"{v:.0f}" for v in row[way]) if way in row else "-" for way in ways)
        print(f"| {os.path.basename(os.path.normpath(folder))}, {problem} | " + " | ".join(cells) + " |")
    for k, count in enumerate(COUNTS):
        cells = []
        for way in ways:
            mine = [row[way][k] for row in shares.values() if way in row]
            top = sum(row[way][k] >= max(r[k] for r in row.values()) - 1e-9 for row in shares.values() if way in row)
            near = sum(row[way][k] >= 0.95 * max(r[k] for r in row.values()) for row in shares.values() if way in row)
            cells.append(f"{statistics.median(mine):.0f} ({top}, {near} of {len(mine)})")
        print(f"| **{count}: median (best, within 5 %)** | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main(sys.argv[1:] or ["runs/evidence"])
