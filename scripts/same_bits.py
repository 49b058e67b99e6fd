#!/usr/bin/env python3
"""Do runs that OLD began go on in NEW with the same bits? same_bits.py [OPTIONS] OLD NEW [CASE...]

OLD and NEW are two programs `strake`; OLD lies in a build folder of its checkout, with make_surface beside it. OLD begins
each case with one evaluation; from a copy of that folder on, OLD and NEW finish it. A run goes on with the meaning it began
with, so histories, variables, values, answers of programs with their gradients, shapes and the report's numbers and pictures
must be the same, but for times and for what only one of the two writes. The cases are the examples of OLD's checkout that
need no solver from outside (--openfoam: those that call OpenFOAM instead), and ten on the surfaces of STRAKE_DATA; shapes of `deform` and the numbers of `info` are compared
as they are.
--begins       NEW makes the first evaluation itself, in a journal that does not say what its keys mean: for programs that do
               not take a folder of OLD
--method NAME  of all runs but fits, in place of their own: NLopt's tell whether two programs evaluate and differentiate alike
               where `sqp` itself has changed
--openfoam     only the examples that call OpenFOAM; minutes each
--evaluations N (default 6), --triangles N of the examples' surfaces (default 2000, at least 1500), --work DIR: keeps the runs
Exit status: 0 the same, 1 different, 2 wrong usage.
"""

import argparse
import csv
import json
import os
import pathlib
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile

RUNS = ["wing/case", "wing/supersonic", "lifting_body/case", "lifting_body/glide", "nacelle/case", "wave_drag/case", "external/case",
        "external/newton", "external/su2/case", "external/cart3d/case"]
# case, its program that makes the mesh, the surface that the mesh is about
OPENFOAM = [("openfoam_drag/adjoint", "drag.py", "body.obj"), ("openfoam_drag/values", "drag.py", "body.obj"),
            ("openfoam_supersonic/case", "wave.py", "body.obj"), ("openfoam_wing/case", "wing.py", "wing.obj")]
FITS = ["wing/fit"]
DEFORMS = ["wing/target", "paper/lifting_body", "paper/wing_lift", "paper/wing_sweep"]
TIMES = re.compile(r"second|elapsed|time|started|ended|version|host|program$|^date|memory|threads")
# Files whose words were rewritten, or that tell of the program itself.
NOT_COMPARED = re.compile(r"^(case\.yaml|journal\.sqlite.*|lock|run\.json|report\.html|history\.csv|series\.py|.*\.log|evaluations/.*)$")

# file, lines of the case, share of the longest axis that is held, parameters, goal
SURFACES = [
    ("bwb_machline_medium.vtk", "", 0.2, "variables: [load], patches_per_level: [2, 6]",
     "objective: {maximize: volume}\nconstraints: {area: {max: 1.001, relative: true}}"),
    ("cgal_joint.off", "", 0.3, "variables: [load], patches_per_level: [4]",
     "objective: {minimize: area}\nconstraints: {volume: {min: 1, relative: true}}"),
    ("cgal_anchor.off", "", 0.3, "variables: [load], patches_per_level: [3, 9]", "objective: {maximize: volume}"),
    ("jet_engine_nacelle_machline.stl", "", 0.2, "variables: [load], patches_per_level: [4, 12]", "objective: {minimize: area}"),
    ("oneraM6_su2_surface.stl", "repair: {orient: true}\n", 0.2, "variables: [load], patches_per_level: [2, 6]",
     "objective: {minimize: area}\noptimize: {method: mma}"),
    ("dpw_w1_pypan.tri", "", 0.2, "variables: [load], levels: [20deg, 10deg]", "objective: {minimize: area}\noptimize: {starts: 2, seed: 5}"),
    ("wing717_pyhyp.ply", "", 0.2, "variables: [load_normal], patches_per_level: [4]", "objective: {minimize: area}"),
    ("of_wigley.stl.gz", "repair: {all: true}\n", 0.2, "variables: [load], patches_per_level: [2, 6]", "objective: {minimize: area}"),
    ("wing_c172_pygeo.stl", "repair: {all: true}\n", 0.2, "variables: [load], patches_per_level: [2, 6]", "objective: {minimize: area}"),
    ("cgal_fandisk_large.off", "", 0.2, "variables: [load], patches_per_level: [2]", "objective: {minimize: area}"),
]


class Failed(Exception):
    """A program that ended with an error; its words."""


def call(program, *words, folder):
    done = subprocess.run([program, *map(str, words)], cwd=folder, capture_output=True, text=True, check=False,
                          env=dict(os.environ, STRAKE_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1"))
    if done.returncode not in (0, 4):  # 4: the budget ended before a level could begin, or alike
        last = (done.stderr.strip().splitlines() or [""])[-1]
        raise Failed(f"{words[0]} ends with {done.returncode}: {last[:200]}")
    return done


def checkout_of(program):
    for folder in pathlib.Path(program).resolve().parents:
        if (folder / "scripts/examples.sh").exists():
            return folder
    raise SystemExit(f"same_bits.py: {program} lies in no checkout")


def copy_examples(old, work, triangles, method):
    """The cases of OLD's checkout, with surfaces that its make_surface makes."""
    root = checkout_of(old)
    shutil.copytree(root / "cases", work / "cases", ignore=shutil.ignore_patterns("generated", "*.cpp", "*.hpp"))
    words = subprocess.run([root / "scripts/examples.sh", work / "cases", pathlib.Path(old).resolve().parent, str(triangles),
                            str(triangles)], capture_output=True, text=True, check=False)
    if words.returncode != 0:
        raise SystemExit(words.stdout + words.stderr)
    for file in (work / "cases").rglob("*.yaml"):
        case = re.sub(r"(budget: *\{evaluations:) *\d+", r"\1 1", file.read_text())
        file.write_text(re.sub(r"method: \w+", f"method: {method}", case) if method and not file.stem.endswith("fit") else case)


def write_surface_case(old, work, row, method):
    file, lines, held, parameters, goal = row
    path = pathlib.Path(os.environ["STRAKE_DATA"]).resolve() / file
    info = json.loads(call(old, "info", path, "--json", folder=work).stdout)
    low, high = info["box"]
    axis = max(range(3), key=lambda k: high[k] - low[k])
    normal = [int(k == axis) for k in range(3)]
    budget = "budget: {evaluations: 1}"
    goal = goal.replace("optimize: {", f"optimize: {{{budget}, ") if "optimize" in goal else f"{goal}\noptimize: {{{budget}}}"
    if method:
        goal = re.sub(r", method: \w+", "", goal).replace(budget, f"{budget}, method: {method}")
    case = work / f"{file.split('.')[0]}.yaml"
    case.write_text(f"surface: {{file: {path}}}\n{lines}"
                    f"regions: {{held: {{plane: {{normal: {normal}, at: {low[axis] + held * (high[axis] - low[axis])!r}}}, side: below}}}}\n"
                    f"fixed: [held]\nshell: {{thickness: 4%}}\nparameters: {{{parameters}, max_displacement: 3%}}\n{goal}\n")
    return case


class Comparison:
    def __init__(self):
        self.numbers, self.files, self.differences = 0, 0, []

    def equal(self, where, one, other):
        self.numbers += 1
        if one != other and not (one != one and other != other):
            self.differences.append(f"{where}: {str(one)[:60]} > {str(other)[:60]}")

    def trees(self, where, one, other):
        """Numbers that stand at the same place of two JSON documents."""
        if isinstance(one, dict) and isinstance(other, dict):
            for key in one.keys() & other.keys():
                if not TIMES.search(key):
                    self.trees(f"{where}.{key}", one[key], other[key])
        elif isinstance(one, list) and isinstance(other, list):
            self.equal(f"{where}: length", len(one), len(other))
            for k, (a, b) in enumerate(zip(one, other)):
                self.trees(f"{where}[{k}]", a, b)
        elif isinstance(one, (int, float)) and isinstance(other, (int, float)):
            self.equal(where, one, other)

    def rows(self, where, one, other, words=()):
        """Rows with names: columns that both have, but for times and what is told in words."""
        self.equal(f"{where}: rows", len(one), len(other))
        for k, (a, b) in enumerate(zip(one, other)):
            for name in a.keys() & b.keys():
                if not TIMES.search(name) and name not in words:
                    self.equal(f"{where} row {k + 1} {name}", a[name], b[name])

    def folders(self, one, other):
        old, new = ({str(f.relative_to(d)) for f in d.rglob("*") if f.is_file()} for d in (one, other))
        for name in sorted(old & new):
            if not NOT_COMPARED.search(name):
                self.files += 1
                if (one / name).read_bytes() != (other / name).read_bytes():
                    self.differences.append(f"{name}: other bytes")
        self.differences += [f"{name}: gone" for name in sorted(old - new) if re.search(r"best|levels/|design_", name)]


def history(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def table(folder, name):
    journal = sqlite3.connect(folder / "journal.sqlite")
    journal.row_factory = sqlite3.Row
    try:
        return [dict(row) for row in journal.execute(f"SELECT * FROM {name} ORDER BY 1, 2")]
    finally:
        journal.close()


def page(folder):
    """What the report holds: its numbers, and each of its pictures' arrays by name."""
    words = (folder / "report.html").read_text(encoding="utf-8") if (folder / "report.html").exists() else ""
    blobs = {"blob-" + name: data for name, data in re.findall(r'<script type="text/plain" id="blob-([^"]*)">(.*?)</script>', words, re.S)}
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', words, re.S)
    return (json.loads(data.group(1)) if data else {}), blobs


def compare_runs(one, other):
    found = Comparison()
    found.rows("history.csv", history(one), history(other), ("status", "reason"))
    found.rows("journal", table(one, "evaluations"), table(other, "evaluations"), ("reason", "hash"))
    found.rows("calls", table(one, "calls"), table(other, "calls"), ("message", "remarks", "hash", "program"))
    found.trees("run.json", *(json.loads((folder / "run.json").read_text()) for folder in (one, other)))
    (numbers, blobs), (numbers_now, blobs_now) = page(one), page(other)
    found.trees("report", numbers, numbers_now)
    found.rows("report", [blobs], [blobs_now])
    found.folders(one, other)
    return found, f"{len(table(other, 'evaluations'))} evaluations"


def begin_as_before(new, work, run, command, case):
    """NEW's own first evaluation, in a journal that does not say what its keys mean: those do not before there were meanings."""
    call(new, command, case, "--out", run, "-q", folder=work)
    with sqlite3.connect(run / "journal.sqlite") as journal:
        journal.execute("DELETE FROM facts WHERE name IN ('meaning', 'hash')")
    journal.close()


def both_finish(old, new, work, name, command, case, evaluations, begins):
    run = work / "runs" / name
    call(old, command, case, "--out", run, "-q", folder=work)
    begun, by_old = run.with_name(name + ".begun"), run.with_name(name + ".old")
    shutil.copytree(run, begun)
    call(old, "resume", run, "--evaluations", evaluations, "-q", folder=work)
    run.rename(by_old)  # NEW's stands where OLD's began: both write the same paths
    if begins:
        begin_as_before(new, work, run, command, case)
    else:
        begun.rename(run)
    call(new, "resume", run, "--evaluations", evaluations, "-q", folder=work)
    return compare_runs(by_old, run)


def both_deform(old, new, work, case):
    found = Comparison()
    for file in ("shape.obj", "shape.stl"):
        shapes = []
        for program in (old, new):
            call(program, "deform", case, "-o", work / file, "-q", folder=work)
            shapes.append((work / file).read_bytes())
            (work / file).unlink()
        found.files += 1
        if shapes[0] != shapes[1]:
            found.differences.append(f"{file}: other bytes")
    return found, "2 shapes"


def both_inform(old, new, work, path):
    found = Comparison()
    found.trees("info", *(json.loads(call(program, "info", path, "--json", folder=work).stdout) for program in (old, new)))
    return found, "info"


def prepare_mesh(folder, program, surface):
    """Once: the answers of a program are compared with those about the same mesh."""
    if not (folder / "prepared").exists():
        done = subprocess.run([folder / program, "prepare", f"generated/{surface}"], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Failed(f"{program} prepare: {(done.stderr.strip().splitlines() or [''])[-1][:200]}")
        (folder / "prepared").touch()


def openfoam_tasks(old, new, work, evaluations, begins):
    for name, program, surface in OPENFOAM:
        case = work / "cases/external" / f"{name}.yaml"
        label = name.replace("/", "-")

        def compare(n=label, f=case, p=program, s=surface):
            prepare_mesh(f.parent, p, s)
            return both_finish(old, new, work, n, "run", f, evaluations, begins)
        yield label, compare


def tasks(old, new, work, evaluations, method, begins):
    """(name, what compares it)."""
    for command, names in (("run", RUNS), ("fit", FITS)):
        for name in names:
            case = work / "cases" / f"{name}.yaml"
            label = name.replace("/", "-")
            yield label, lambda c=command, n=label, f=case: both_finish(old, new, work, n, c, f, evaluations, begins)
    for name in DEFORMS:
        yield f"deform {name}", lambda f=work / "cases" / f"{name}.yaml": both_deform(old, new, work, f)
    for row in SURFACES if os.environ.get("STRAKE_DATA") else []:
        label = row[0].split(".")[0]
        yield label, lambda n=label, r=row: both_finish(old, new, work, n, "run", write_surface_case(old, work, r, method), evaluations,
                                                  begins)
        yield f"info {label}", lambda r=row: both_inform(old, new, work, pathlib.Path(os.environ["STRAKE_DATA"]).resolve() / r[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--method")
    parser.add_argument("--begins", action="store_true")
    parser.add_argument("--openfoam", action="store_true")
    parser.add_argument("--evaluations", type=int, default=6)
    parser.add_argument("--triangles", type=int, default=2000)
    parser.add_argument("--work", type=pathlib.Path, help="folder for the runs, kept; it must not exist")
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("cases", nargs="*", help="words in the names of those to compare; none: all")
    args = parser.parse_args()
    old, new = (str(pathlib.Path(program).resolve()) for program in (args.old, args.new))
    work = args.work.resolve() if args.work else pathlib.Path(tempfile.mkdtemp(prefix="same_bits_"))
    work.mkdir(exist_ok=not args.work)
    (work / "runs").mkdir()
    copy_examples(old, work, args.triangles, args.method)
    different = count = 0
    print("| case | what | numbers, files | |\n|---|---|---|---|")
    all_tasks = (openfoam_tasks(old, new, work, args.evaluations, args.begins) if args.openfoam
                 else tasks(old, new, work, args.evaluations, args.method, args.begins))
    for name, compare in all_tasks:
        if args.cases and not any(word in name for word in args.cases):
            continue
        count += 1
        try:
            found, what = compare()
            said = "same" if not found.differences else f"**{len(found.differences)} differ**: {found.differences[0]}"
            print(f"| {name} | {what} | {found.numbers}, {found.files} | {said} |", flush=True)
            for words in found.differences[1:8]:
                print(f"    {words}", file=sys.stderr, flush=True)
            different += bool(found.differences)
        except Failed as failure:
            different += 1
            print(f"| {name} | | | **{failure}** |", flush=True)
    print(f"{different} of {count} differ" if different else f"all {count} the same")
    if not args.work:
        shutil.rmtree(work)
    return 1 if different or not count else 0


if __name__ == "__main__":
    sys.exit(main())
