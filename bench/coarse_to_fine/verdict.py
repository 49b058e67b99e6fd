#!/usr/bin/env python3
"""Does the choice of variables pay? Compares a way with patches alone and with the box.

verdict.py FOLDER... [--way fields] [--way-method sqp] [--references FILE] [--write-enough | --write-references FILE]

FOLDER: one for each seed, as strake_evidence --out writes it, with the ways adaptive (patches) and ffd (box) by sqp, and
the one that is compared. Evaluations to 90 and 99 % of the better end of patches and box, of each of the three. Medians
over the folders, where a run that never gets there counts as infinite. --write-enough: writes FOLDER/enough.csv, the
objective at 99 %, where a run of another way may end (strake_evidence --enough). --write-references: what patches and
box of the folders did, a line each; --references: they did what such a file says, by the seed in the folder's name.
"""

import argparse
import csv
import glob
import math
import os
import re
import statistics


REFERENCE_METHOD = "sqp"  # of patches and box
REFERENCE_WAYS = ("adaptive", "ffd")
SHARES = (0.9, 0.99)
PHYSICAL = ("wave_drag", "lift_over_drag", "bending_energy", "wing_volume", "frontal_area", "section_areas")


def trace(folder, problem, way, method):
    path = os.path.join(folder, f"{problem}-{way}-{method}-trace.csv")
    if not os.path.exists(path):
        return None
    with open(path, newline="") as file:
        return [(int(r["evaluation"]), float(r["best"])) for r in csv.DictReader(file)]


def start_of(points):
    return next((best for _, best in points if not math.isnan(best)), math.nan)


def seed_of(folder):
    return re.search(r"(\d+)/*$", folder).group(1)


def read_references(path):
    """By seed and problem."""
    if not path:
        return {}
    with open(path, newline="") as file:
        return {(row["seed"], row["problem"]): row for row in csv.DictReader(file)}


class Problem:
    """One problem with one seed. reference: its line in a file of them, in place of traces of patches and box."""

    def __init__(self, folder, name, way, method, reference=None):
        self.reference = reference
        self.traces = {w: None if reference else trace(folder, name, w, REFERENCE_METHOD) for w in REFERENCE_WAYS}
        self.traces[way] = trace(folder, name, way, method)
        if reference:
            self.start, self.best = float(reference["start"]), float(reference["best"])
            return
        known = [t for w in REFERENCE_WAYS if (t := self.traces[w])]
        self.start = start_of(known[0]) if known else math.nan
        self.best = min((t[-1][1] for t in known if not math.isnan(t[-1][1])), default=math.nan)

    def at(self, share):
        return self.start - share * (self.start - self.best)

    def reach(self, way, share):
        """First evaluation at this share of the decrease; infinite: never; None: not run."""
        if self.reference and way in REFERENCE_WAYS:
            return float(self.reference[f"{way}_{100 * share:g}"])
        if not self.traces.get(way):
            return None
        return next((e for e, best in self.traces[way] if best <= self.at(share)), math.inf)

    def end(self, way):
        points = self.traces.get(way)
        return 100 * (self.start - points[-1][1]) / (self.start - self.best) if points else math.nan


def median(values):
    values = [v for v in values if v is not None]
    return statistics.median(values) if values else None


def cell(value):
    return "" if value is None else "-" if math.isinf(value) else f"{value:.0f}"


def write_references(path, folders, names):
    reached = [f"{way}_{100 * share:g}" for way in REFERENCE_WAYS for share in SHARES]
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["seed", "problem", "start", "best"] + reached)
        for folder in sorted(folders, key=lambda f: int(seed_of(f))):
            for name in names:
                p = Problem(folder, name, "", "")
                if math.isnan(p.best):
                    continue
                counts = [p.reach(way, share) for way in REFERENCE_WAYS for share in SHARES]
                if None in counts:
                    raise SystemExit(f"{folder}: {name} was not run by both of {' and '.join(REFERENCE_WAYS)}")
                out.writerow([seed_of(folder), name, repr(p.start), repr(p.best)] + counts)


def write_enough(folder, names, references):
    with open(os.path.join(folder, "enough.csv"), "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["problem", "method", "objective"])
        for name in names:
            p = Problem(folder, name, "fields", REFERENCE_METHOD, references.get((seed_of(folder), name)))
            for method in ("sqp", "model"):
                if not math.isnan(p.best):
                    out.writerow([name, method, repr(p.at(0.99))])


def table(folders, names, way, method, share, references):
    lines = [f"Evaluations to {100 * share:g} % of the better end of patches and box", "",
             f"| problem | patches | box | {way} | {way} / sooner | end, % |", "|---|---|---|---|---|---|"]
    ratios = {}
    for name in names:
        runs = [Problem(folder, name, way, method, references.get((seed_of(folder), name))) for folder in folders]
        patches, box, own = (median([r.reach(w, share) for r in runs]) for w in (*REFERENCE_WAYS, way))
        if own is None:
            continue
        # Of each seed, against the sooner of the two of the same seed.
        each = []
        for r in runs:
            theirs = [v for v in (r.reach("adaptive", share), r.reach("ffd", share)) if v is not None]
            mine = r.reach(way, share)
            if mine is not None and theirs and not math.isinf(min(theirs)):
                each.append(mine / min(theirs))
        if not each:
            continue
        ratios[name] = median(each)
        end = median([r.end(way) for r in runs if not math.isnan(r.end(way))])
        lines.append(f"| {name} | {cell(patches)} | {cell(box)} | {cell(own)} | "
                     f"{'-' if math.isinf(ratios[name]) else format(ratios[name], '.2f')} | {end:.1f} |")
    others = [ratio for name, ratio in ratios.items() if name not in PHYSICAL]
    physical = [ratio for name, ratio in ratios.items() if name in PHYSICAL]
    counts = [sum(ratio <= limit for ratio in others) for limit in (0.5, 1.1, 1.5)]
    lines += ["", f"At most half: {counts[0]} of {len(others)}; sooner or within 10 %: {counts[1]}; at most 1.5 times: "
              f"{counts[2]}. Physical problems, sooner or equal: {sum(r <= 1 for r in physical)} of {len(physical)}.", ""]
    return lines


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("folders", nargs="+")
    arguments.add_argument("--way", default="fields")
    arguments.add_argument("--way-method", default="sqp")
    arguments.add_argument("--references")
    arguments.add_argument("--write-enough", action="store_true")
    arguments.add_argument("--write-references")
    given = arguments.parse_args()
    references = read_references(given.references)
    missing = {seed_of(f) for f in given.folders} - {seed for seed, _ in references}
    if references and missing:
        arguments.error(f"{given.references} has no seed {', '.join(sorted(missing))}")
    names = list(dict.fromkeys(name for _, name in references))
    for folder in [] if references else given.folders:
        found = sorted(glob.glob(os.path.join(folder, f"*-{REFERENCE_METHOD}-runs.csv")), key=os.path.getmtime)
        for path in found:
            name = os.path.basename(path).split("-")[0]
            if name not in names:
                names.append(name)
    if given.write_enough:
        for folder in given.folders:
            write_enough(folder, names, references)
        return
    if given.write_references:
        return write_references(given.write_references, given.folders, names)
    for share in SHARES:
        print("\n".join(table(given.folders, names, given.way, given.way_method, share, references)))


if __name__ == "__main__":
    main()
