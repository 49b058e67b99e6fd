#!/usr/bin/python3
"""What coarse to fine is worth on problems with known answers: published_levels.py [--bin FOLDER] [--write] [NAME...]

Runs cases of cases/published with the finest level only (all fields at once), with fields from coarse to fine, with patches of a shell, with both, and
by a box of B-splines (bench/published: the build tree of --bin holds strake_box), and prints after how many evaluations each came within 10 %,
1 % and 0.1 % of the published value. --write: the table of docs/published.md, and its chart, of all that was run in this folder.
"""
import argparse
import json
import math
import pathlib
import re
import shutil
import subprocess

import published
from published import CASES, areas, child_seconds, history

PICTURE = published.ROOT / "docs/pictures/levels.svg"


def of_volume(run):
    rows = history(run)
    return float(rows[0]["objective"]) / (1 + float(rows[0]["excess"]))  # at the start's volume or area


def of_base(run):
    return areas.judge(run / "best.obj", "base")["least"]


def by_efficiency(best):
    """Drag times span efficiency is the same for all designs of this lift."""
    def least(run):
        row = published.best_row(history(run))
        return float(row["objective"]) * float(row["wing.efficiency"]) / best
    return least


def of_wing_body(run):
    return areas.judge_wing_body(published.surface_of(run), CASES / "generated/wing_panels.obj", 1.0)["least"]


def of_power_law(run):
    drags = []
    for n in published.EXPONENTS:
        made = published.surfaces.nose(n, 4000)
        drags.append(published.nose.drag(run / "judge", (published.np.array(made.vertices), published.np.array(made.triangles)), 6.0))
    return published.best_power(drags)[1]


#          case: published value of the objective, by the run with the finest level only; None: the least that any way found
LEAST = {
    "sears_haack": of_volume,
    "haack": of_volume,
    "karman": of_base,
    "wing_body_1": of_wing_body,
    "newton_1": lambda run: published.newton.least(1)[0],
    "twist_10": by_efficiency(1),
    "nonplanar": by_efficiency(1.4186),
    "sbend": lambda run: 6.40740e-7,
    "stokes": lambda run: 0.95425 * float(history(run)[0]["objective"]),  # the start is the sphere
    "nose_6": of_power_law,
    "transonic": None,
}
TRIANGLES, BUDGETS = {"stokes": 500}, {"nonplanar": 60}  # else those of the published run
# Points along x, y, z and where they move: about as many variables as the case has fields. Bodies of revolution stay such, and so does
# what is held, so that of a lattice of n x 2 x 2 one variable each is left for most of the n layers.
BOXES = {
    "sears_haack": ("37x2x2", "yz"), "haack": ("37x2x2", "yz"), "karman": ("37x2x2", "yz"), "wing_body_1": ("102x2x2", "yz"),
    "newton_1": ("11x2x2", "yz"), "twist_10": ("2x3x1", "z"), "nonplanar": ("2x5x1", "yz"), "stokes": ("5x2x2", "xyz"), "nose_6": ("7x2x2", "yz"),
}


def box_of_openfoam(_):
    """OpenFOAM's own optimizer is a box already: 9 x 5 x 3 volumetric B-splines, BFGS (docs/published.md, run again here)."""
    return [{"variant": "box", "end": "budget, OpenFOAM's own", "seconds": 700, "values": [7.17675e-7, 7.13710e-7, 6.70202e-7, 6.51984e-7, 6.40740e-7]}]


def box_of_race(out):
    """The better one of the transonic wing's race, where published.sh has run that."""
    traces = [published.bests_of(path) for path in (out / "transonic/box").glob("*.csv")]
    if not traces:
        print("transonic: without the box, its race was not run")
        return []
    return [{"variant": "box", "end": "budget", "seconds": None, "values": min(traces, key=lambda values: values[-1])}]


KNOWN = {"sbend": box_of_openfoam, "transonic": box_of_race}  # boxes that are run elsewhere
VARIANTS = {
    "finest only": lambda text: text,
    "fields, coarse to fine": lambda text: re.sub(r"number: \d+", "number: auto", text),
    "patches": lambda text: with_shell(re.sub(r"parameters: \{.*?max_displacement: (\S+)\}",
                                              r"parameters: {levels: auto, variables: [normal], max_displacement: \1}", text)),
    "fields and patches": lambda text: with_shell(re.sub(r"number: \d+", "number: auto", text).replace("variables: []", "variables: [normal]")),
    "box": lambda text: text,
}
# The same of cases with `fields: auto`, which are coarse to fine as they come.
BY_VALUES = {"finest only": "fields: {number: 60}", "fields, coarse to fine": "fields: auto", "patches": "fields: none\n  variables: [normal]",
             "fields and patches": "fields: auto\n  variables: [normal]"}
# A shell would push the nose ahead: another height, another problem. That of the bend was not tried: seventy seconds an evaluation.
ONLY_FIELDS = ("newton_1", "nose_6", "sbend")
REACHED = (0.1, 0.01, 0.001)
WORDS = {"no_valid_step": "no valid step", "converged": "converged", "budget": "budget", "roundoff": "rounding"}


def with_shell(text):
    return text.replace("shell: none", "shell: {thickness: 1%}").replace("hold: none", "hold: point")


def prepared(name):
    """The start surface, and what lies beside it."""
    problem = published.PROBLEMS[name]
    start = CASES / "generated" / f"{problem.start}.obj"
    start.parent.mkdir(exist_ok=True)
    if problem.prepare:
        subprocess.run([CASES / problem.prepare.split()[0], *problem.prepare.split()[1:], "prepare"], check=True)
        return start
    if name in TRIANGLES:
        start = start.with_stem(f"{problem.start}_{TRIANGLES[name]}")
    published.write(problem.start, TRIANGLES.get(name, problem.triangles), start)
    if problem.beside:
        published.write(problem.beside, 2000, CASES / "generated" / f"{problem.beside}.obj")
    return start


def varied(text, variant):
    """The text of a case with these variables. One whose fields come as they come is by values, and has lines of its own."""
    if "fields: auto" not in text:
        return VARIANTS[variant](text)
    text = text.replace("fields: auto", BY_VALUES[variant]) if variant in BY_VALUES else text
    return with_shell(text) if "patches" in variant else text


def written_case(name, variant, start, run):
    """The case of this variant beside the folder of the run, where paths are those of cases/published."""
    text = (CASES / f"{published.PROBLEMS[name].case or name}.yaml").read_text(encoding="utf-8")
    text = re.sub(r"file: \S+\.obj", f"file: {start}", text, count=1)
    text = varied(text, variant)
    for relative in ("transonic/m6.py", "./lattice.py", "./stokes.py", "./nose.py", "./sbend.py", "{case_dir}", "beside: generated"):
        key, colon, path = relative.rpartition(": ")
        text = text.replace(relative, key + colon + str(CASES / path.replace("{case_dir}", "")))
    case = run.with_suffix(".yaml")
    case.write_text(text, encoding="utf-8")
    return case


def run_variant(name, variant, start, options):
    """Its history and how it ended; None where its program is not built."""
    run = options.out / "levels" / f"{name}_{list(VARIANTS).index(variant)}"
    shutil.rmtree(run, ignore_errors=True)
    run.parent.mkdir(parents=True, exist_ok=True)
    command = [options.bin / "strake", "run", "-q"]
    if variant == "box":
        command = [options.bin.parent / "bench/published/strake_box", "--points", BOXES[name][0], "--moves", BOXES[name][1]]
        if not command[0].exists():
            print(f"{name}: without the box, {command[0]} is not built")
            return None
    command += [written_case(name, variant, start, run), "--out", run]
    for setting in published.PROBLEMS[name].settings:
        command += ["--set", setting.replace("./nose.py", str(CASES / "nose.py"))]
    if name in BUDGETS:
        command += ["--set", f"optimize.budget.evaluations={BUDGETS[name]}"]
    before = child_seconds()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    seconds = child_seconds() - before
    if not (run / "best.obj").exists():
        return {"variant": variant, "end": done.stdout.strip().split("\n")[-1][:80], "seconds": seconds, "values": []}
    status = re.search(r"status +(\S+)", done.stdout).group(1)
    end, reason = WORDS.get(status, status), re.search(r"reason +(.*)", done.stdout)
    if reason and "buckles" in reason.group(1):
        end += ": folds" if "shell: none" in (run.with_suffix(".yaml")).read_text(encoding="utf-8") else ": buckles or folds"
    values = [float(row["objective"]) if row["status"] == "ok" and float(row["max_violation"]) <= 1e-4 else None for row in history(run)]
    return {"variant": variant, "end": end, "seconds": seconds, "values": values}


def run_problem(name, options):
    start, done = prepared(name), []
    for variant in VARIANTS:
        if variant in ("patches", "fields and patches") and name in ONLY_FIELDS or variant == "box" and name not in BOXES:
            continue
        one = run_variant(name, variant, start, options)
        if one:
            done.append(one)
            print(name, variant, f"{one['seconds']:.0f} s", one["end"], flush=True)
    if name in KNOWN:
        done += KNOWN[name](options.out)
    found = [value for one in done for value in one["values"] if value is not None]
    least = LEAST[name](options.out / "levels" / f"{name}_0") if LEAST[name] else min(found)
    for one in done:  # the share that is too much; not at all lifts or volumes a value
        one["excess"] = [None if value is None else value / least - 1 for value in one.pop("values")]
    (options.out / "levels" / f"{name}.json").write_text(json.dumps(done), encoding="utf-8")


def table(results):
    lines = ["| problem | variables | to 10 % | to 1 % | to 0.1 % | end, % above | evaluations | seconds of CPU | ended by |",
             "|---|---|---|---|---|---|---|---|---|"]
    for name, variants in results.items():
        for k, one in enumerate(variants):
            good = [(n, value) for n, value in enumerate(one["excess"], 1) if value is not None]
            first = [min((n for n, value in good if value <= limit), default=None) for limit in REACHED]
            best = f"{100 * min(value for _, value in good):.3g}" if good else "–"
            cells = [f"`{name}`" if k == 0 else "", one["variant"], *("–" if n is None else str(n) for n in first), best,
                     str(len(one["excess"])), "–" if one["seconds"] is None else f"{one['seconds']:.0f}", one["end"]]
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


COLOURS = {"finest only": "#222222", "fields, coarse to fine": "#1f77b4", "patches": "#d62728", "fields and patches": "#9467bd", "box": "#2ca02c"}
WIDTH, HEIGHT, LOW, HIGH = 180, 110, -4, 1  # of a chart, and its powers of ten
COLUMNS = 5


def curve(excess, count):
    """The best so far, as steps."""
    best, points = math.inf, []

    def at(n, value):
        y = HEIGHT * (HIGH - min(max(math.log10(max(value, 1e-9)), LOW), HIGH)) / (HIGH - LOW)
        return f"{WIDTH * n / count:.1f},{y:.1f}"
    for n, value in enumerate(excess, 1):
        if value is not None and value < best:
            if points:
                points.append(at(n, best))
            best = value
            points.append(at(n, best))
    return " ".join(points + [at(len(excess), best)]) if points else ""


def chart(results):
    rows = -(-len(results) // COLUMNS)
    across, down = WIDTH + 52, HEIGHT + 48
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {COLUMNS * across + 10} {rows * down + 28}" font-family="sans-serif" font-size="11">',
             '<rect width="100%" height="100%" fill="white"/>']
    for k, (name, variants) in enumerate(results.items()):
        count = max(len(one["excess"]) for one in variants)
        parts += [f'<g transform="translate({k % COLUMNS * across + 48},{k // COLUMNS * down + 22})">', f'<text x="0" y="-6" font-weight="bold">{name}</text>',
                  f'<rect width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999999"/>',
                  f'<text x="{WIDTH}" y="{HEIGHT + 13}" text-anchor="end">{count}</text>']
        for power in range(LOW, HIGH + 1):
            y = HEIGHT * (HIGH - power) / (HIGH - LOW)
            parts.append(f'<path d="M0 {y:g}H{WIDTH}" stroke="#e0e0e0"/><text x="-4" y="{y + 4:g}" text-anchor="end">{100 * 10.0**power:g} %</text>')
        parts += [f'<polyline fill="none" stroke="{COLOURS[one["variant"]]}" stroke-width="1.4" points="{curve(one["excess"], count)}"/>'
                  for one in variants if curve(one["excess"], count)]
        parts.append("</g>")
    x = 48
    for word, colour in COLOURS.items():
        parts.append(f'<path d="M{x} {rows * down + 12}h20" stroke="{colour}" stroke-width="2"/><text x="{x + 25}" y="{rows * down + 16}">{word}</text>')
        x += 50 + 7 * len(word)
    return "\n".join(parts + ["</svg>", ""])


def write_page(results):
    page = published.ROOT / "docs/published.md"
    head, rest = page.read_text(encoding="utf-8").split("<!-- levels -->\n")
    page.write_text(head + "<!-- levels -->\n\n" + table(results) + "\n\n<!-- end of levels -->" + rest.split("<!-- end of levels -->")[1],
                    encoding="utf-8")
    PICTURE.write_text(chart(results), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--write", action="store_true", help="table and chart of docs/published.md")
    parser.add_argument("--out", type=pathlib.Path, default=published.ROOT / "build/published")
    parser.add_argument("--bin", type=pathlib.Path, default=published.ROOT / "build/release/programs", help="folder of strake")
    parser.add_argument("names", nargs="*", help=", ".join(LEAST))
    options = parser.parse_args()
    unknown = [n for n in options.names if n not in LEAST]
    if unknown:
        parser.error(f"no problem is called {unknown[0]}; there are {', '.join(LEAST)}")
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    for name in options.names or LEAST:
        run_problem(name, options)
    stored = {name: options.out / "levels" / f"{name}.json" for name in LEAST}
    results = {name: json.loads(path.read_text(encoding="utf-8")) for name, path in stored.items() if path.exists()}
    print(table({name: one for name, one in results.items() if name in (options.names or LEAST)}))
    if options.write:
        write_page(results)


if __name__ == "__main__":
    main()
