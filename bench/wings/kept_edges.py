#!/usr/bin/python3
"""What a run with section variables alone leaves of a wing's planform: both edges, chord and twist.

    kept_edges.py FOLDER [--strake PROGRAM] [--out DIR] [--only NAME] [--variables fields|normal] [--motion 1%]

FOLDER holds the surfaces of STRAKE_DATA. Each case grows the volume of its wing (of a wing that lets no section grow:
changes it) by displacement fields, or by normal loads on patches, and nothing of the planform. Start and end are measured
by `strake info --planform` (in planes at fractions of the present semispan, which moves where a winglet gets thicker) and
by sections that numpy makes in planes that stay: largest motion of leading and trailing edge over the chord, largest change
of twist, and how far the surface itself has moved. Ends with 1 by the latter where an edge moves by more than 1e-4 of
the chord or twist by more than 0.02 degrees.
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from found_wings import airfoil, pieces, read_obj, unit  # noqa: E402

STATIONS = [0.05, 0.13, 0.25, 0.37, 0.5, 0.61, 0.74, 0.86, 0.93]


def thickness(x, blunt):
    return 5 * (0.2969 * math.sqrt(x) - 0.126 * x - 0.3516 * x ** 2 + (0.2843 + blunt) * x ** 3 - 0.1036 * x ** 4)


def loft(path, rows, around=96, blunt=0.0):
    """Half a wing of rows of sections: (place of the quarter chord, direction normal to the section, chord, twist)."""
    n, vertices, faces = around // 2, [], []
    cosine = [(1 + math.cos(math.pi * k / n)) / 2 for k in range(n + 1)]
    loop = [(x, 1) for x in cosine] + [(x, -1) for x in reversed(cosine[:-1])]
    if blunt == 0:
        loop = loop[:-1]
    for place, angle, chord, twist in rows:
        up = numpy.array([0, -math.sin(angle), math.cos(angle)])
        for x, side in loop:
            z = side * 0.12 * thickness(x, blunt) + 0.02 * 4 * x * (1 - x) if 0 < x < 1 or blunt else 0.0
            turned = complex(x - 0.25, z) * numpy.exp(-1j * twist)
            vertices.append(place + chord * (numpy.array([turned.real, 0, 0]) + turned.imag * up))
    m = len(loop)
    for r in range(len(rows) - 1):
        for k in range(m):
            a, b = r * m + k, r * m + (k + 1) % m
            faces += [(a, a + m, b), (b, a + m, b + m)]
    first = (len(rows) - 1) * m
    low, high = 0, m - 1 if blunt else m
    while high - low > 1:  # the tip is flat
        a, b = first + low, first + (high % m)
        if high - low > 2:
            faces += [(a, b, a + 1), (a + 1, b, first + (high - 1))]
        else:
            faces.append((a, b, a + 1))
        low, high = low + 1, high - 1
    with open(path, "w") as out:
        out.writelines("v %.12g %.12g %.12g\n" % tuple(v) for v in vertices)
        out.writelines("f %d %d %d\n" % (a + 1, b + 1, c + 1) for a, b, c in faces if len({a, b, c}) == 3)


def straight(count=48, blunt=0.0):
    def make(path):
        rows = [(numpy.array([0.25 + 1.2 * s, 3 * s, 0.3 * s]), 0.0, 1 - 0.5 * s, 0.0 if blunt else 0.05 - 0.08 * s)
                for s in (k / count for k in range(count + 1))]
        loft(path, rows, blunt=blunt)
    return make


def winglet_rows():
    rows, place = [], numpy.array([0.25, 0.0, 0.0])
    length, bend, height = 2.7, 0.35, 0.55  # flat, bend of 80 degrees, straight again
    total = length + bend * math.radians(80) + height
    count, before = 72, 0.0
    for k in range(count + 1):
        s = total * k / count
        angle = min(max((s - length) / bend, 0.0), math.radians(80))
        middle = 0.5 * (angle + (rows[-1][1] if rows else 0))
        step = s - before
        place = place + step * numpy.array([0.4, math.cos(middle), math.sin(middle)]) if k else place
        rows.append((place, angle, 1 - 0.6 * s / total, 0.0))
        before = s
    return rows


def winglet(path):
    loft(path, winglet_rows())


def program(*words):
    def make(path):
        subprocess.run([*words, "-o", path], check=True, capture_output=True)
    return make


HALF_Y = "symmetry: {plane: y, at: 0}\n"
UP_Y = "axes: {downstream: +x, up: +y}\n"
# name: (file or what makes it, what the case adds, (span, downstream, up), regions that are held)
BODIES = {
    "half model": (straight(), HALF_Y, ("+y", "+x", "+z"), ""),
    "blunt trailing edge": (straight(blunt=0.02), HALF_Y, ("+y", "+x", "+z"), ""),
    "winglet": (winglet, HALF_Y, ("+y", "+x", "+z"), ""),
    "body": (program(str(pathlib.Path(__file__).parent / "wing_body.py"), "--triangles", "12000"), HALF_Y, ("+y", "+x", "+z"),
             "regions:\n  body: {plane: {normal: [0, 1, 0], at: 0.0901}, side: below}\nfixed: [body]\n"),
    "three elements": ("three_element_wing_cpanel.tri", "regions:\n  main: {component: 0}\n", ("+y", "+x", "+z"), ""),
    "wing717": ("wing717_pyhyp.ply", UP_Y, ("+z", "+x", "+y"), ""),
    "dpw_w1": ("dpw_w1_pypan.tri", "", ("-y", "+x", "+z"), ""),
    "ONERA M6, coarse": ("oneraM6_su2_surface.stl", "", ("+y", "+x", "+z"), ""),
    "ONERA M6": ("oneraM6_pyhyp_small.ply", UP_Y, ("+z", "+x", "+y"), ""),
    "Cessna 172": ("wing_c172_pygeo.stl", UP_Y, ("+z", "+x", "+y"), ""),
}
ROOT_HELD = ("regions:\n  root: {plane: {normal: [%s], at: %.6g}, side: below, touch: any}\nfixed: [root]\n")


def case_of(name, surface, options, points):
    made, extra, (span, _, _), held = BODIES[name]
    way = unit(span)
    if not held and options.variables == "fields":
        held = "hold: none\n"
    elif not held:  # the first 6 % of the semispan of a half, the middle of a whole wing
        along = points @ way
        low, high = along.min(), along.max()
        whole = low < -0.5 * high
        if whole:
            held = ("regions:\n  root: {box: [[%s], [%s]], touch: any}\nfixed: [root]\n" % tuple(
                ", ".join("%.6g" % x for x in ((points.min(0) - 1) if s < 0 else (points.max(0) + 1)) * (1 - abs(way))
                          + s * 0.06 * high * abs(way)) for s in (-1, 1)))
        else:
            held = ROOT_HELD % (", ".join("%g" % x for x in way), low + 0.06 * (high - low))
    on = "on: all - %s, " % held.split("fixed: [")[1].split("]")[0] if "fixed" in held else ""
    on = "on: main, " if name == "three elements" else on  # without its wake and flaps
    letter = span[1]
    goal = ("objective: {maximize: volume}\nconstraints:\n  area: {max: 1.02, relative: true}\n"
            if name != "three elements" else "objective: {maximize: area}\nconstraints:\n  change: {max: 1e-3}\n")
    moved = ("shell: none\nparameters:\n  fields: auto\n" if options.variables == "fields"
             else "parameters:\n  variables: [normal]\n  patches_per_level: [8, 24]\n")
    return ("case: kept\nsurface: {file: %s}\nrepair: {degenerate: true, cracks: 1e-3%%}\n%s%splanform:\n  wing: {%sspan: %s, "
            "stations: [0, 0.35, 0.7, 1]}\n%s  max_displacement: %s\nquantities:\n  change: {type: displacement}\n%s"
            "optimize: {budget: {evaluations: %d}}\n"
            % (surface, extra, held, on, letter, moved, options.motion, goal, options.evaluations))


def by_strake(program, best, start):
    def stations(*words):
        answer = subprocess.run([program, "info", "--planform", "--json", *words, "--stations",
                                 ",".join(map(str, STATIONS))], capture_output=True, text=True, timeout=300)
        shown = json.loads(answer.stdout).get("planform") if answer.returncode == 0 else None
        return shown
    now = stations(best, "--start", start)
    if not now:
        return None
    before = now.get("start", {}).get("stations") or stations(start)["stations"]
    worst = [0.0, 0.0, 0.0]
    for a, b in zip(before, now["stations"]):
        for k, edge in enumerate(("leading_edge", "trailing_edge")):
            worst[k] = max(worst[k], numpy.linalg.norm(numpy.subtract(a[edge], b[edge])) / a["chord"])
        worst[2] = max(worst[2], abs(math.degrees(b["twist"] - a["twist"])))
    return worst


def edges(flat):
    """Leading and trailing edge of a section as docs/planform.md defines them; also how many points the nose has."""
    end = flat[flat[:, 0] > flat[:, 0].max() - 2e-4 * numpy.ptp(flat[:, 0])]  # the corners of a blunt edge that stands upright
    aft = 0.5 * (end[end[:, 1].argmin()] + end[end[:, 1].argmax()])
    lead = flat[numpy.linalg.norm(flat - aft, axis=1).argmax()]
    line = aft - lead
    chord = numpy.linalg.norm(line)
    along, up = line / chord, numpy.array([-line[1], line[0]]) / chord
    x, z = (flat - lead) @ along / chord, (flat - lead) @ up / chord
    near = x < 0.04
    if near.sum() < 7:
        return lead, aft, near.sum()
    fit = numpy.polynomial.Polynomial.fit(z[near], x[near], 4, w=1 - x[near] / 0.04, domain=[-0.1, 0.1], window=[-1, 1])
    at = 0.0
    for _ in range(30):
        at -= fit.deriv()(at) / fit.deriv(2)(at)
    return lead + chord * (fit(at) * along + at * up), aft, near.sum()


def planes(points, name):
    """Unit normal, direction up, a point of each section that is looked at."""
    span, _, up = (unit(w) for w in BODIES[name][2])
    along = points @ span
    root = max(along.min(), 0)
    if name != "winglet":
        return [(span, up, span * (root + s * (along.max() - root)), numpy.inf) for s in STATIONS]
    found = []
    for (a, angle, chord, _), (b, after, *_) in zip(winglet_rows(), winglet_rows()[1:]):
        mean = 0.5 * (angle + after)
        if mean == 0 or mean > math.radians(79):  # off the bend; not the tip
            found.append((numpy.array([0, math.cos(mean), math.sin(mean)]), numpy.array([0, -math.sin(mean), math.cos(mean)]),
                          0.5 * (a + b), 0.9 * chord))
    return found[2:-1:3]


def by_numpy(points, moved, triangles, name):
    """In planes that stay where they are at the start."""
    downstream, worst, few = unit(BODIES[name][2][1]), [0.0, 0.0, 0.0], 99
    for normal, up, place, near in planes(points, name):
        seen = []
        for where in (points, moved):
            limit = 0.99 if name == "three elements" else None
            cut = [g for g in pieces(where, triangles, normal, place @ normal) if numpy.linalg.norm(g.mean(0) - place) < near]
            section = airfoil(cut, downstream, up, (limit, None))
            if section is None:
                return None
            seen.append(edges(numpy.stack([section @ downstream, section @ up], 1)))
        (lead, aft, count), (lead_now, aft_now, _) = seen
        chord, few = numpy.linalg.norm(aft - lead), min(few, count)
        turn = [math.atan2(e[0][1] - e[1][1], e[1][0] - e[0][0]) for e in seen]
        worst = [max(worst[0], numpy.linalg.norm(lead - lead_now) / chord), max(worst[1], numpy.linalg.norm(aft - aft_now) / chord),
                 max(worst[2], abs(math.degrees(turn[0] - turn[1])))]
    return worst + [few]


def run(name, options):
    made = BODIES[name][0]
    folder = options.out / name.replace(" ", "_").replace(",", "")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    source = folder / "source.obj"
    if callable(made):
        made(str(source))
    else:
        subprocess.run([options.strake, "repair", "--isolated", "-q", "-o", source, options.folder / made], check=True,
                       capture_output=True)
    points, _ = read_obj(source)
    (folder / "case.yaml").write_text(case_of(name, source.resolve(), options, points))
    done = subprocess.run([options.strake, "run", folder / "case.yaml", "--out", folder / "run", "--json"],
                          capture_output=True, text=True, timeout=1200)
    if done.returncode not in (0, 1) or not (folder / "run" / "best.obj").exists():
        return print(f"| {name} | no run: {(done.stdout + done.stderr).strip()[:300]} |", flush=True) or False
    first, best = folder / "run" / "start.obj", folder / "run" / "best.obj"
    points, triangles = read_obj(first)
    moved, _ = read_obj(best)
    motion = numpy.linalg.norm(moved - points, axis=1).max()
    own = by_strake(options.strake, best, first)
    other = by_numpy(points, moved, triangles, name)
    shown = lambda w: "not found | | " if w is None else f"{w[0]:.1e} | {w[1]:.1e} | {w[2]:.4f}"  # noqa: E731
    few = other[3] if other else ""
    result = json.loads(done.stdout)
    print(f"| {name} | {len(triangles)} | {result.get('evaluations')} | {motion / numpy.ptp(points, axis=0).max():.4f} | "
          f"{shown(own)} | {shown(other)} | {few} |", flush=True)
    judged = own if name.startswith("blunt") else other  # numpy does not know the corners of a blunt edge that leans
    return judged is not None and max(judged[:2]) <= 1.05e-4 and judged[2] <= 0.02


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--strake", default="strake")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/kept_edges"))
    parser.add_argument("--only", default="")
    parser.add_argument("--variables", choices=("fields", "normal"), default="fields")
    parser.add_argument("--motion", default="1%")
    parser.add_argument("--evaluations", type=int, default=8)
    options = parser.parse_args()
    print("| wing | triangles | evaluations | farthest motion, of the length | leading edge, of the chord | trailing edge | "
          "twist, deg | leading edge by numpy | trailing edge | twist, deg | points of a nose |\n|---|---|---|---|---|---|---|---|---|---|---|")
    good = [run(name, options) for name in BODIES if options.only in name]
    print(f"\n{sum(good)} of {len(good)} keep their edges to 1e-4 of the chord and twist to 0.02 degrees")
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
