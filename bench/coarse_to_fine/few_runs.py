#!/usr/bin/env python3
"""What few evaluations buy: the table of few_runs.sh.

few_runs.py BUDGET FOLDER...   reads *-trace.csv of strake_evidence, a FOLDER for each seed. Prints for every problem and way
the median over the seeds of the gain after BUDGET evaluations, in percent of the largest of all ways; on how many problems
each way is highest, and within 5 % of the highest, by these medians and by single runs; and how many rounds of eight places
the first way takes to the gain that the best of those that ask one design after another has in the end, over the evaluations of that.
"""

import csv
import glob
import math
import os
import statistics
import sys

SERIAL = (("uniform", "sqp"), ("uniform", "cobyla"), ("uniform", "bobyqa"))
PLACES = 8


def traces(folder):
    """Best feasible objective by evaluation, for each problem and way (solver, method)."""
    found = {}
    for path in sorted(glob.glob(os.path.join(folder, "*-trace.csv"))):
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                way = row["solver"], row["method"]
                found.setdefault(row["problem"], {}).setdefault(way, []).append(float(row["best"]))
    return found


def best_after(trace, count):
    known = [v for v in trace[:count] if not math.isnan(v)]
    return min(known) if known else math.inf


def reached(trace, value):
    """Evaluations until the best is no higher than `value`; infinite if it never is."""
    return next((i + 1 for i, v in enumerate(trace) if v <= value), math.inf)


def shares_of(ways, count):
    start = next(t[0] for t in ways.values() if not math.isnan(t[0]))
    gains = {way: max(0.0, start - best_after(t, count)) for way, t in ways.items()}
    most = max(gains.values())
    return {way: 100 * gain / most if most > 0 else 0.0 for way, gain in gains.items()}


def rounds_over_serial(ways, count):
    """Of the first way, over the evaluations of the best serial one; infinite if it does not get that far."""
    serial = [ways[w] for w in SERIAL if w in ways]
    value = min(best_after(t, count) for t in serial)
    alone = min(reached(t, value) for t in serial)
    if value == math.inf:
        return 1 / alone
    in_batches = reached(next(iter(ways.values())), value)
    return math.inf if in_batches == math.inf else (1 + math.ceil((in_batches - 1) / PLACES)) / alone


def main(count, folders):
    seeds = [traces(folder) for folder in folders]
    problems = [p for p in seeds[0] if all(p in seed for seed in seeds)]
    ways = list(dict.fromkeys(w for seed in seeds for p in problems for w in seed[p]))
    ways.sort(key=lambda w: w[0] != "as_it_comes")
    print("| problem | " + " | ".join(f"{s} {m}" for s, m in ways) + " | rounds over serial |")
    print("|---" * (len(ways) + 2) + "|")
    highest, near, single = dict.fromkeys(ways, 0), dict.fromkeys(ways, 0), dict.fromkeys(ways, (0, 0))
    quarter = 0
    for p in problems:
        rows = [shares_of({w: seed[p][w] for w in ways if w in seed[p]}, count) for seed in seeds]
        median = {w: statistics.median(r[w] for r in rows) for w in ways if all(w in r for r in rows)}
        top = max(median.values())
        for way, share in median.items():
            highest[way] += share >= top - 1e-9
            near[way] += share >= 0.95 * top
        for row in rows:
            for way, share in row.items():
                single[way] = single[way][0] + (share >= 100 - 1e-9), single[way][1] + (share >= 95)
        ratio = statistics.median(rounds_over_serial({w: s[p][w] for w in ways if w in s[p]}, count) for s in seeds)
        quarter += ratio <= 0.25
        print(f"| {p} | " + " | ".join(f"{median[w]:.0f}" if w in median else "" for w in ways) + f" | {ratio:.2f} |")
    print("| highest, within 5 % | " + " | ".join(f"{highest[w]}, {near[w]}" for w in ways) + f" | {quarter} at most 0.25 |")
    print("| single runs | " + " | ".join(f"{single[w][0]}, {single[w][1]}" for w in ways) + " | |")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(int(sys.argv[1]), sys.argv[2:])
