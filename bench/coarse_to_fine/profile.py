#!/usr/bin/env python3
"""Tables and data profiles of the evidence suite.

profile.py FOLDER   reads *-runs.csv and *-trace.csv in FOLDER, writes summary.csv, table.md and four plots (SVG).

The best known decrease of a problem is the largest that any solver reached. A solver has reached 90, 99 or 99.9 % at
its first evaluation whose best feasible objective makes that share of it. Data profiles: More and Wild, SIAM J. Optim.
20 (2009), against evaluations and CPU seconds as they are.
"""

import csv
import glob
import math
import os
import sys

SHARES = (0.9, 0.99, 0.999)
STRAKE = ("fields", "adaptive", "uniform", "finest")
COLOURS = {"fields": "#222222", "adaptive": "#c0392b", "uniform": "#e08e0b", "finest": "#2c6fbb", "ffd": "#3a923a",
           "lattice_4x4x4": "#17a2a2", "lattice_8x4x2": "#a0a01a", "filtered": "#7d4fa8"}


def read(folder):
    """Runs and traces by (problem, solver, method)."""
    runs, traces = {}, {}
    for path in sorted(glob.glob(os.path.join(folder, "*-runs.csv"))):
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                runs[row["problem"], row["solver"], row["method"]] = row
    for path in sorted(glob.glob(os.path.join(folder, "*-trace.csv"))):
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                key = row["problem"], row["solver"], row["method"]
                traces.setdefault(key, []).append(
                    (int(row["evaluation"]), float(row["cpu"]), float(row["best"]), int(row["paid"])))
    return runs, traces


def first_at(trace, start, wanted):
    """(evaluations, CPU, evaluations with gradients by differences) at which the decrease reaches `wanted`, or None."""
    for evaluation, cpu, best, paid in trace:
        if start - best >= wanted:
            return evaluation, cpu, paid
    return None


class Results:
    def __init__(self, folder):
        self.runs, self.traces = read(folder)
        self.problems = list(dict.fromkeys(key[0] for key in self.runs))
        self.ways = sorted({key[1:] for key in self.runs}, key=lambda w: (list(COLOURS).index(w[0]), w[1] != "sqp"))
        self.start, self.best, self.best_strake = {}, {}, {}
        for problem in self.problems:
            starts = [t[0][2] for key, t in self.traces.items() if key[0] == problem and not math.isnan(t[0][2])]
            self.start[problem] = starts[0] if starts else math.nan
            for target, solvers in ((self.best, tuple(COLOURS)), (self.best_strake, STRAKE)):
                gains = [self.gain(key) for key in self.traces if key[0] == problem and key[1] in solvers]
                target[problem] = max([g for g in gains if not math.isnan(g)], default=math.nan)

    def gain(self, key):
        """Decrease at the end of a run; NaN when it has no feasible design."""
        trace = self.traces.get(key)
        return self.start[key[0]] - trace[-1][2] if trace else math.nan

    def reach(self, key, share, best=None):
        best = best or self.best
        if key not in self.traces or math.isnan(best[key[0]]):
            return None
        return first_at(self.traces[key], self.start[key[0]], share * best[key[0]])

    def share(self, key):
        """Of the best known decrease, at the end."""
        gain = self.gain(key)
        return 0.0 if math.isnan(gain) else gain / self.best[key[0]]

    def methods(self, solver, problem):
        return [key[2] for key in self.runs if key[0] == problem and key[1] == solver]


def cell(at):
    return "-" if at is None else f"{at[0]} / {at[1]:.1f}"


def problem_tables(r):
    lines = []
    for problem in r.problems:
        first = next(row for key, row in r.runs.items() if key[0] == problem)
        lines += [f"### {problem}", "",
                  f"{first['triangles']} triangles, best known decrease {r.best[problem]:.6g} from {r.start[problem]:.6g}"
                  f" (Strake's best: {100 * r.best_strake[problem] / r.best[problem]:.2f} % of it).", "",
                  "| solver | method | variables | evaluations (failed) | CPU (s) | decrease at the end | 90 % | 99 % |"
                  " 99.9 % | end |", "|---|---|---|---|---|---|---|---|---|---|"]
        for way in r.ways:
            key = (problem, *way)
            row = r.runs.get(key)
            if row is None:
                continue
            reached = " | ".join(cell(r.reach(key, share)) for share in SHARES)
            lines.append(f"| {way[0]} | {way[1]} | {row['levels']} | {row['evaluations']} ({row['failures']}) |"
                         f" {float(row['cpu']):.1f} | {100 * r.share(key):.2f} % | {reached} | {row['status']} |")
        lines.append("")
    return lines


def best_reach(r, problem, solver, share, best=None):
    """The fewest evaluations over the methods, and that method."""
    found = [(r.reach((problem, solver, m), share, best), m) for m in r.methods(solver, problem)]
    found = [(at[0], m) for at, m in found if at is not None]
    return min(found) if found else None


def pairs(r, method_of):
    """Problems on which the adaptive run and the finest level were both run, with the methods to compare."""
    for problem in r.problems:
        for method in method_of(problem):
            if (problem, "adaptive", method) in r.runs and (problem, "finest", method) in r.runs:
                yield problem, method


def count_against_finest(r, kind, best, label, column=0):
    """One row: how often adaptive needs at most half, at most 1.1 times, and ends not worse by more than 1 %.
    column 0: evaluations, 2: with gradients by differences."""
    half = within = no_worse = total = undecided = 0
    exceptions = []
    for problem, method in pairs(r, lambda p: [m for m in r.methods("adaptive", p) if (m == "sqp") == (kind == "sqp")]):
        total += 1
        a = r.reach((problem, "adaptive", method), 0.99, best)
        f = r.reach((problem, "finest", method), 0.99, best)
        if a is None and f is None:
            undecided += 1
            exceptions.append(f"{problem} (neither)")
        elif f is None:
            half += 1
            within += 1
        elif a is None:
            exceptions.append(f"{problem} (only finest, at {f[column]})")
        else:
            half += a[column] <= 0.5 * f[column]
            within += a[column] <= 1.1 * f[column]
            if a[column] > 0.5 * f[column]:
                exceptions.append(f"{problem} ({a[column]} against {f[column]})")
        loss = r.gain((problem, "finest", method)) - r.gain((problem, "adaptive", method))
        no_worse += not loss > 0.01 * r.best[problem]
    return (f"| {kind} | {label} | {half} of {total} | {within} of {total} | {undecided} | {no_worse} of {total} |"
            f" {'; '.join(exceptions) or '-'} |")


def against_ffd(r, kind):
    wins = faster = total = 0
    lost = []
    for problem in r.problems:
        for method in r.methods("adaptive", problem):
            if (method == "sqp") != (kind == "sqp") or (problem, "ffd", method) not in r.runs:
                continue
            total += 1
            a, f = (problem, "adaptive", method), (problem, "ffd", method)
            better = r.gain(a) >= r.gain(f) or math.isnan(r.gain(f))
            wins += better
            at_a, at_f = r.reach(a, 0.99), r.reach(f, 0.99)
            faster += at_a is not None and (at_f is None or at_a[0] <= at_f[0])
            if not better:
                lost.append(f"{problem} ({100 * r.share(a):.2f} against {100 * r.share(f):.2f} %)")
    return f"| {kind} | {wins} of {total} | {faster} of {total} | {'; '.join(lost) or '-'} |"


def counts(r):
    lines = ["## Counts", "", "Adaptive against the finest level alone, the same method. The decrease is that known from all solvers,"
             " or from Strake's own alone (where a comparator leaves all of them behind, 99 % of the first says nothing about levels).",
             "Gradients by differences: what the same run would cost a solver that gives values only: one evaluation more for each variable",
             "of the level at every evaluation, and at every refinement one for each variable that could be chosen.",
             "", "| method | 99 % of | at most half of the evaluations | at most 1.1 times | neither reaches it | end not worse"
             " by 1 % | not half |", "|---|---|---|---|---|---|---|"]
    for kind in ("sqp", "first-order"):
        for best, label in ((r.best, "all"), (r.best_strake, "Strake's")):
            lines.append(count_against_finest(r, kind, best, label))
        lines.append(count_against_finest(r, kind, r.best_strake, "Strake's, gradients by differences", 2))
    lines += ["", "Adaptive against the Bezier box of equal size, the same method.", "",
              "| method | lower at the end | 99 % no later | lower with the box |", "|---|---|---|---|"]
    lines += [against_ffd(r, kind) for kind in ("sqp", "first-order")]
    return lines + [""]


def overview(r):
    lines = ["## Share of the best known decrease at the end (%)", "",
             "| problem | " + " | ".join(f"{s} {m}" for s, m in columns(r)) + " |",
             "|---|" + "---|" * len(columns(r))]
    for problem in r.problems:
        cells = []
        for solver, kind in columns(r):
            method = next((m for m in r.methods(solver, problem) if (m == "sqp") == (kind == "sqp")), None)
            cells.append("-" if method is None else f"{100 * r.share((problem, solver, method)):.2f}")
        lines.append(f"| {problem} | " + " | ".join(cells) + " |")
    return lines + [""]


def columns(r):
    seen = dict.fromkeys((solver, "sqp" if method == "sqp" else "first-order") for solver, method in r.ways)
    return list(seen)


def write_summary(r, folder):
    with open(os.path.join(folder, "summary.csv"), "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["problem", "solver", "method", "variables", "evaluations", "cpu", "share_at_end"]
                     + [f"{what}_{100 * s:g}" for s in SHARES for what in ("evaluations", "cpu")])
        for key, row in r.runs.items():
            reached = [r.reach(key, share) or ("", "", "") for share in SHARES]
            out.writerow([*key, row["variables"], row["evaluations"], row["cpu"], f"{r.share(key):.6f}"]
                         + [v for at in reached for v in at[:2]])


def profile(r, column, share, path):
    """One plot: fraction of problems solved against evaluations (column 0) or CPU (column 1)."""
    width, height, left, bottom, top = 720, 420, 60, 50, 30
    curves = {}
    for solver, kind in columns(r):
        at = []
        for problem in r.problems:
            for method in r.methods(solver, problem):
                if (method == "sqp") == (kind == "sqp"):
                    found = r.reach((problem, solver, method), share)
                    at += [] if found is None else [max(found[column], 0.01)]
        curves[solver, kind] = sorted(at)
    every = [v for at in curves.values() for v in at] or [1, 10]
    low, high = math.log10(min(every)) - 0.05, math.log10(max(every)) + 0.05
    plot = width - left - 190

    def x(value):
        return left + plot * (math.log10(value) - low) / (high - low)

    def y(fraction):
        return top + (height - top - bottom) * (1 - fraction)

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif"'
           ' font-size="12">', f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="18" font-size="14">problems solved to {100 * share:g} % of the best known decrease</text>']
    for k in range(5):
        svg.append(f'<line x1="{left}" x2="{left + plot}" y1="{y(k / 4):.1f}" y2="{y(k / 4):.1f}" stroke="#ddd"/>'
                   f'<text x="{left - 8}" y="{y(k / 4) + 4:.1f}" text-anchor="end">{25 * k} %</text>')
    for decade in range(math.floor(low), math.ceil(high) + 1):
        for digit in (1, 2, 5):
            value = digit * 10.0**decade
            if low <= math.log10(value) <= high:
                svg.append(f'<line x1="{x(value):.1f}" x2="{x(value):.1f}" y1="{top}" y2="{y(0):.1f}" stroke="#ddd"/>'
                           f'<text x="{x(value):.1f}" y="{y(0) + 16:.1f}" text-anchor="middle">{value:g}</text>')
    axis = ("evaluations", "CPU seconds")[column]
    svg.append(f'<text x="{left + plot / 2:.0f}" y="{height - 12}" text-anchor="middle">{axis}</text>')
    for i, ((solver, kind), at) in enumerate(curves.items()):
        dash = "" if kind == "sqp" else ' stroke-dasharray="6 3"'
        points, count = [f"{left},{y(0):.1f}"], len(r.problems)
        for k, value in enumerate(at):
            points += [f"{x(value):.1f},{y(k / count):.1f}", f"{x(value):.1f},{y((k + 1) / count):.1f}"]
        points.append(f"{left + plot},{y(len(at) / count):.1f}")
        svg.append(f'<polyline points="{" ".join(points)}" fill="none" stroke="{COLOURS[solver]}" stroke-width="2"{dash}/>')
        row = top + 16 + 20 * i
        svg.append(f'<line x1="{left + plot + 14}" x2="{left + plot + 44}" y1="{row}" y2="{row}" stroke="{COLOURS[solver]}"'
                   f' stroke-width="2"{dash}/><text x="{left + plot + 52}" y="{row + 4}">{solver}, {kind}</text>')
    with open(path, "w") as file:
        file.write("\n".join(svg + ["</svg>", ""]))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = sys.argv[1]
    r = Results(folder)
    if not r.problems:
        sys.exit(f"profile.py: no *-runs.csv in {folder}")
    write_summary(r, folder)
    for share in (0.9, 0.99):
        for column, name in enumerate(("evaluations", "cpu")):
            profile(r, column, share, os.path.join(folder, f"profile-{name}-{100 * share:g}.svg"))
    lines = overview(r) + counts(r) + ["## Problem by problem", "", "Evaluations / CPU seconds to reach a share.", ""]
    cpu = sum(float(row["cpu"]) for row in r.runs.values())
    lines += problem_tables(r) + [f"CPU in all: {cpu / 60:.1f} minutes.", ""]
    with open(os.path.join(folder, "table.md"), "w") as file:
        file.write("\n".join(lines))


if __name__ == "__main__":
    main()
