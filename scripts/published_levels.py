#!/usr/bin/python3
"""What coarse to fine is worth on problems with known answers: published_levels.py [--bin FOLDER] [--write] [NAME...]

Runs some cases of cases/published with the finest level only (all fields at once), with fields from coarse to fine, with patches of a shell, and with both,
and prints after how many evaluations each came within 10 %, 1 % and 0.1 % of the published value. --write: the table of
docs/published.md.
"""
import argparse
import pathlib
import re
import resource
import shutil
import subprocess

import published

WING_BODY_BOUND = None  # of the start's volume; set when it is known
STOKES_SPHERE = None  # of the sphere's triangles
#           case: value over the published one, of a row of the history
EXCESS = {
    "sears_haack": lambda row: float(row["excess"]),
    "haack": lambda row: float(row["excess"]),
    "karman": None,  # its least drag belongs to the base, which is held
    "newton_1": lambda row: float(row["objective"]) / published.newton.least(1)[0] - 1,
    "twist_10": lambda row: 1 / float(row["wing.efficiency"]) - 1,
    "wing_body_1": lambda row: float(row["objective"]) / WING_BODY_BOUND - 1,
    "stokes": lambda row: float(row["objective"]) / STOKES_SPHERE / 0.95425 - 1,
    "nonplanar": lambda row: 1.4186 / float(row["wing.efficiency"]) - 1,
}
PATCHES = "parameters: {levels: auto, variables: [normal], max_displacement: 3%}"
VARIANTS = {
    "finest only": lambda text: text,
    "fields, coarse to fine": lambda text: re.sub(r"number: \d+", "number: auto", text),
    "patches": lambda text: with_shell(re.sub(r"parameters: .*", PATCHES, text)),
    "fields and patches": lambda text: with_shell(re.sub(r"number: \d+", "number: auto", text).replace("variables: []", "variables: [normal]")),
}
# A shell would push the nose ahead: another height, another problem.
ONLY_FIELDS = ("newton_1",)
REACHED = (0.1, 0.01, 0.001)


def with_shell(text):
    return text.replace("shell: none", "shell: {thickness: 1%}").replace("hold: none", "hold: point")


def excess_of(name, run):
    global WING_BODY_BOUND, STOKES_SPHERE
    if name == "wing_body_1" and WING_BODY_BOUND is None:
        WING_BODY_BOUND = published.areas.judge_wing_body(published.surface_of(run), published.CASES / "generated/wing_panels.obj", 1.0)["least"]
    if name == "stokes" and STOKES_SPHERE is None:
        STOKES_SPHERE = float(published.history(run)[0]["objective"])
    if EXCESS[name] is not None:
        return EXCESS[name]
    least = published.areas.judge(run / "best.obj", "base")["least"]
    return lambda row: float(row["objective"]) / least - 1


def run_variant(name, variant, options):
    problem = published.PROBLEMS[name]
    start = published.CASES / "generated" / f"{problem.start}.obj"
    start.parent.mkdir(exist_ok=True)
    published.write(problem.start, problem.quick or problem.triangles, start)
    if problem.beside:
        published.write(problem.beside, 2000, published.CASES / "generated" / f"{problem.beside}.obj")
    text = (published.CASES / f"{problem.case or name}.yaml").read_text(encoding="utf-8")
    text = re.sub(r"file: \S+\.obj", f"file: {start}", text, count=1)
    text = VARIANTS[variant](text)
    for relative in ("./lattice.py", "./stokes.py", "{case_dir}", "beside: generated"):  # the case lies in the folder of runs
        key, colon, path = relative.rpartition(": ")
        text = text.replace(relative, key + colon + str(published.CASES / path.replace("{case_dir}", "")))
    run = options.out / "levels" / f"{name}_{list(VARIANTS).index(variant)}"
    shutil.rmtree(run, ignore_errors=True)
    run.parent.mkdir(parents=True, exist_ok=True)
    case = run.with_suffix(".yaml")
    case.write_text(text, encoding="utf-8")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([options.bin / "strake", "run", case, "--out", run, "-q"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    reason = re.search(r"reason +(.*)", done.stdout)
    if not (run / "best.obj").exists():
        return [name, variant, "–", "–", "–", "–", "0", f"{seconds:.0f}", done.stdout.strip().split("\n")[-1][:80]]
    rows, excess = published.history(run), excess_of(name, run)
    good = [(int(row["evaluation"]), excess(row)) for row in rows if row["status"] == "ok" and float(row["max_violation"]) <= 1e-4]
    first = [min((n for n, value in good if value <= limit), default=None) for limit in REACHED]
    best = min((value for _, value in good), default=float("nan"))
    words = {"no_valid_step": "no valid step", "converged": "converged", "budget": "budget", "roundoff": "rounding"}
    status = re.search(r"status +(\S+)", done.stdout).group(1)
    end = words.get(status, status)
    if reason and "buckles" in reason.group(1):
        end += ": folds" if "shell: none" in text else ": buckles or folds"
    return [name, variant, *("–" if n is None else str(n) for n in first), f"{100 * best:.3g}", str(len(rows)), f"{seconds:.0f}", end]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help="the table of docs/published.md")
    parser.add_argument("--out", type=pathlib.Path, default=published.ROOT / "build/published")
    parser.add_argument("--bin", type=pathlib.Path, default=published.ROOT / "build/release/programs", help="folder of strake")
    parser.add_argument("names", nargs="*", help=", ".join(EXCESS))
    options = parser.parse_args()
    unknown = [n for n in options.names if n not in EXCESS]
    if unknown:
        parser.error(f"no problem is called {unknown[0]}; there are {', '.join(EXCESS)}")
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    lines = ["| problem | variables | to 10 % | to 1 % | to 0.1 % | end, % above | evaluations | seconds of CPU | ended by |",
             "|---|---|---|---|---|---|---|---|---|"]
    print("\n".join(lines))
    for name in options.names or EXCESS:
        for k, variant in enumerate(list(VARIANTS)[:2 if name in ONLY_FIELDS else None]):
            row = run_variant(name, variant, options)
            row[0] = f"`{name}`" if k == 0 else ""
            lines.append("| " + " | ".join(row) + " |")
            print(lines[-1], flush=True)
    if options.write:
        page = published.ROOT / "docs/published.md"
        head, rest = page.read_text(encoding="utf-8").split("<!-- levels -->\n")
        page.write_text(head + "<!-- levels -->\n\n" + "\n".join(lines) + "\n\n<!-- end of levels -->" + rest.split("<!-- end of levels -->")[1],
                        encoding="utf-8")


if __name__ == "__main__":
    main()
