#!/bin/bash
# Does NEW do what OLD did? same_behaviour.sh [--evaluations N] [--triangles N] [--only WORD] OLD NEW
# OLD and NEW are two programs `strake`, each in a build folder of its own checkout, with make_surface beside it: the cases
# of that checkout are run by it. Runs the shipped examples that need no solver from outside and, where STRAKE_DATA is a
# folder of surfaces, ten cases on those; compares exit codes, what is printed, histories, best shapes, designs, levels,
# series and reports byte by byte, but for times, versions and the words of the table RENAMED below.
# N evaluations a run (default 8), N triangles of the examples' surfaces (default 2000, at least 1500): ten minutes on two cores.
# Exit status: 0 the same, 1 different, 2 wrong usage.
set -euo pipefail
evaluations=8 triangles=2000 only=
while [ $# -gt 2 ]; do
    case $1 in
    --evaluations) evaluations=$2 ;;
    --triangles) triangles=$2 ;;
    --only) only=$2 ;;
    *) break ;;
    esac
    shift 2
done
[ $# = 2 ] && [ -x "$1" ] && [ -x "$2" ] || { sed -n 2p "$0" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

checkout() {  # PROGRAM: the folder above it that has the cases
    local folder
    folder=$(dirname "$(realpath "$1")")
    while [ ! -e "$folder/scripts/examples.sh" ]; do
        [ "$folder" != / ] || { echo "same_behaviour.sh: $1 lies in no checkout" >&2; return 1; }
        folder=$(dirname "$folder")
    done
    echo "$folder"
}
prepare() {  # PROGRAM SIDE
    local root maker
    root=$(checkout "$1")
    maker=$(dirname "$1")/make_surface
    [ -x "$maker" ] || maker=$(dirname "$1")/../cases/geometry/make_surface
    mkdir -p "$work/$2/bin" "$work/$2/runs"
    ln -s "$(realpath "$1")" "$work/$2/bin/strake"
    ln -s "$(realpath "$maker")" "$work/$2/bin/make_surface"
    (cd "$root" && find cases \( -name generated -prune \) -o -type f \( -name '*.yaml' -o -name '*.csv' -o -name '*.py' -o -name '*.sh' \) -print0 |
        xargs -0 cp --parents -t "$work/$2")
    # The budgets, and nothing else.
    find "$work/$2/cases" -name '*.yaml' -exec sed -i -E "s/(budget: *\{evaluations:) *[0-9]+/\1 $evaluations/" {} +
    "$root/scripts/examples.sh" "$work/$2/cases" "$work/$2/bin" "$triangles" "$triangles" >"$work/$2.log" 2>&1 ||
        { cat "$work/$2.log" >&2; return 1; }
}
echo "making the examples' surfaces" >&2
prepare "$1" old
prepare "$2" new

cat >"$work/compare.py" <<'PYTHON'
import concurrent.futures
import csv
import json
import os
import re
import subprocess
import sys

work, evaluations, only = sys.argv[1], int(sys.argv[2]), sys.argv[3]

# What was called differently before: (in which files, pattern of the old word, new word).
RENAMED = [
    (r"case\.yaml$", r"\bgives:", "outputs:"),
    (r"case\.yaml$", r"\bwanted:", "target:"),
    (r"case\.yaml$", r"\bfreeze:", "frozen:"),
    (r"case\.yaml$", r"\bon:", "variables_on:"),
    (r"case\.yaml$", r"\bpoints_reach:", "support_radius:"),
    (r"case\.yaml$", r"\bassociations:", "icp_iterations:"),
    (r"case\.yaml$", r"\bpromise_below:", "min_expected_gain:"),
    (r"case\.yaml$", r"\bsplit_share:", "marking_fraction:"),
    (r"case\.yaml$", r"\bgrowth:", "max_variable_ratio:"),
    (r"case\.yaml$", r"\bcore:", "free_border:"),
    (r"case\.yaml$|report\.html$|stdout$", r"\bload_normal\b", "normal_load"),
    (r"case\.yaml$|report\.html$|stdout$", r"\bslsqp\b", "sqp"),
    (r"stdout$|\.csv$|\.json$|report\.html$", r"\bblocked\b", "no_valid_step"),
]
# What differs from run to run: times, versions, places.
VARYING = [
    (r".", r'"(seconds|cpu_seconds|total_seconds|started|ended|version|host|folder|elapsed)": *("[^"]*"|[-+.0-9e]+)', r'"\1": _'),
    (r"stdout$|report\.html$", r"\b[0-9.]+(e[-+]?[0-9]+)? (ms|s|min|h)\b", "_ s"),
    (r".", re.escape(work) + r"/(old|new)", "_"),
    (r"report\.html$", r"(?s)<(script|style)(?![^>]*application/json)[^>]*>.*?</\1>", ""),
]
# Words (reasons, notes, help) were rewritten: where only these differ the run is the same. They are counted and shown once.
WORDS = re.compile(r"stderr$")
NOT_COMPARED = re.compile(r"journal\.sqlite|/lock$|/evaluations/|\.log$")

SURFACES = [  # file, repair, held share of the longest axis, parameters, goal, extra
    ("bwb_machline_medium.vtk", "", 0.2, "variables: [load], patches_per_level: [2, 6]", "maximize: volume", "constraints: {area: {max: 1.001, relative: true}}"),
    ("cgal_joint.off", "", 0.3, "variables: [load], patches_per_level: [4]", "minimize: area", "constraints: {volume: {min: 1, relative: true}}"),
    ("cgal_anchor.off", "", 0.3, "variables: [load], patches_per_level: [3, 9]", "maximize: volume", "remesh: {angle: 30deg}"),
    ("jet_engine_nacelle_machline.stl", "", 0.2, "variables: [load], patches_per_level: [4, 12]", "minimize: area", ""),
    ("oneraM6_su2_surface.stl", "repair: {orient: true}", 0.2, "variables: [load], patches_per_level: [2, 6]", "minimize: area", "optimize: {method: mma, budget: {evaluations: EVALUATIONS}}"),
    ("dpw_w1_pypan.tri", "", 0.2, "variables: [load], levels: [20deg, 10deg]", "minimize: area", "optimize: {starts: 2, seed: 5, budget: {evaluations: EVALUATIONS}}"),
    ("hsct_pypan.tri", "repair: {all: true}", 0.2, "variables: [load], patches_per_level: [4]", "minimize: area", ""),
    ("of_wigley.stl.gz", "repair: {all: true}", 0.2, "variables: [load], patches_per_level: [2, 6]", "minimize: area", ""),
    ("wing_c172_pygeo.stl", "repair: {all: true}", 0.2, "variables: [load], patches_per_level: [2, 6]", "minimize: area", ""),
    ("x43_parts.ply", "repair: {all: true}", 0.2, "variables: [load], patches_per_level: [4]", "minimize: area", ""),
    ("two_objects_mixed_case_trimesh.stl", "", 0.5, "variables: [load], patches_per_level: [2]", "minimize: area", ""),
]


def run(side, name, arguments):
    out = os.path.join(work, side, "runs", name)
    os.makedirs(out, exist_ok=True)
    environment = dict(os.environ, STRAKE_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    with open(f"{out}.stdout", "wb") as words, open(f"{out}.stderr", "wb") as errors:
        status = subprocess.call([os.path.join(work, side, "bin/strake"), *arguments], cwd=os.path.join(work, side),
                                 stdout=words, stderr=errors, env=environment)
    return status


def cases():
    """(name, arguments): the same for both programs; every path is relative to a side's folder."""
    for name, command in (("wing/case", "run"), ("wing/fit", "fit"), ("wing/supersonic", "run"), ("lifting_body/case", "run"),
                          ("lifting_body/glide", "run"), ("nacelle/case", "run"), ("wave_drag/case", "run"),
                          ("external/case", "run"), ("external/newton", "run"), ("external/su2/case", "run"), ("external/cart3d/case", "run")):
        label = name.replace("/", "-")
        yield label, [command, f"cases/{name}.yaml", "--out", f"runs/{label}", "--json"]
    for name in ("wing/target", "paper/lifting_body", "paper/wing_lift", "paper/wing_sweep"):
        label = name.replace("/", "-")
        yield label, ["deform", f"cases/{name}.yaml", "-o", f"runs/{label}/shape.obj", "--json"]
    yield "wing-check", ["check", "cases/wing/case.yaml", "--json"]
    yield "wing-patches", ["patches", "cases/wing/generated/wing.obj", "--angle", "auto", "--json"]
    yield "unknown-key", ["check", "bad.yaml"]
    data = os.environ.get("STRAKE_DATA")
    for surface in SURFACES if data else []:
        name = surface[0].split(".")[0]
        yield f"{name}-info", ["info", os.path.join(data, surface[0]), "--json"]
        yield name, ["run", f"{name}.yaml", "--out", f"runs/{name}", "--json"]


def write_surface_cases():
    data = os.environ.get("STRAKE_DATA")
    for side in ("old", "new"):
        with open(os.path.join(work, side, "bad.yaml"), "w") as out:
            out.write("case: bad\nsurface: {file: none.obj}\n")
        for file, repair, held, parameters, goal, extra in SURFACES if data else []:
            if only not in file.split(".")[0]:
                continue
            path = os.path.join(data, file)
            info = json.loads(subprocess.check_output([os.path.join(work, "old/bin/strake"), "info", path, "--json"]))
            low, high = info["box"]
            axis = max(range(3), key=lambda k: high[k] - low[k])
            normal = [int(k == axis) for k in range(3)]
            at = low[axis] + held * (high[axis] - low[axis])
            if "optimize:" not in extra:
                extra += "\noptimize: {budget: {evaluations: EVALUATIONS}}"
            with open(os.path.join(work, side, file.split(".")[0] + ".yaml"), "w") as out:
                out.write(f"surface: {{file: {path}}}\n{repair}\nregions: {{held: {{plane: {{normal: {normal}, at: {at!r}}}, side: below}}}}\n"
                          f"fixed: [held]\nshell: {{thickness: 4%}}\nparameters: {{{parameters}, max_displacement: 3%}}\n"
                          f"objective: {{{goal}}}\n{extra.replace('EVALUATIONS', str(evaluations))}\n")


def numbers_of(match):
    """Sentences were rewritten; their numbers stay."""
    return f'"{match.group(1)}": [{" ".join(re.findall(r"[0-9][-+.0-9e]*", match.group(2)))}]'


def normal(name, content, is_old):
    try:
        words = content.decode()
    except UnicodeDecodeError:
        return content
    words = re.sub(r'"(reason|stop|why|note|warning|warnings|advice)": *"((?:[^"\\]|\\.)*)"', numbers_of, words)
    for where, pattern, new in RENAMED if is_old else []:
        if re.search(where, name):
            words = re.sub(pattern, new, words)
    for where, pattern, new in VARYING:
        if re.search(where, name):
            words = re.sub(pattern, new, words)
    return words.encode()


def files_of(side, name):
    base = os.path.join(work, side, "runs")
    found = [f"{name}.stdout", f"{name}.stderr"]
    for folder, _, names in os.walk(os.path.join(base, name)):
        found += [os.path.relpath(os.path.join(folder, one), base) for one in names]
    return {one for one in found if not NOT_COMPARED.search("/" + one)}


def first_difference(a, b):
    if b"\0" in a or b"\0" in b:
        place = next((k for k, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
        return f"{len(a)} and {len(b)} bytes, the first other one is {place}"
    one, other = a.decode(errors="replace").split("\n"), b.decode(errors="replace").split("\n")
    k = next((k for k, (x, y) in enumerate(zip(one, other)) if x != y), min(len(one), len(other)))
    line = lambda lines: lines[k][:300] if k < len(lines) else "(ends)"
    if len(line(one)) == 300 or len(line(other)) == 300:
        x, y = (one + [""])[k], (other + [""])[k]
        at = next((j for j, (p, q) in enumerate(zip(x, y)) if p != q), 0)
        return f"line {k + 1}, column {at + 1}\n      old: …{x[max(0, at - 40):at + 120]}\n      new: …{y[max(0, at - 40):at + 120]}"
    return f"line {k + 1}\n      old: {line(one)}\n      new: {line(other)}"


def compare(name, statuses):
    """Lines of what differs, and how many files do not but for words."""
    differences, same, words = [], 0, 0
    if statuses[0] != statuses[1]:
        differences.append(f"exit code {statuses[0]}, now {statuses[1]}")
    old, new = files_of("old", name), files_of("new", name)
    differences += [f"only {side}: {one}" for side, some in (("old", old - new), ("new", new - old)) for one in sorted(some)]
    for one in sorted(old & new):
        a, b = (open(os.path.join(work, side, "runs", one), "rb").read() for side in ("old", "new"))
        if normal(one, a, True) == normal(one, b, False):
            same += 1
        elif WORDS.search(one):
            words += 1
        else:
            differences.append(f"{one}: {first_difference(normal(one, a, True), normal(one, b, False))}")
    return differences, same, words


write_surface_cases()
failed = 0
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    for name, arguments in cases():
        if only not in name:
            continue
        statuses = list(pool.map(lambda side: run(side, name, arguments), ("old", "new")))
        differences, same, words = compare(name, statuses)
        failed += bool(differences)
        print(f"{'DIFFERS' if differences else 'same   '} {name}: status {statuses[1]}, {same} files the same"
              + (f", {words} with other words on stderr" if words else ""), flush=True)
        for difference in differences[:12]:
            print(f"    {difference}", flush=True)
print(f"{failed} differ" if failed else "all the same")
sys.exit(1 if failed else 0)
PYTHON
python3 "$work/compare.py" "$work" "$evaluations" "$only"
