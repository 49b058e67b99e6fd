#!/usr/bin/python3
"""Runs the problems of cases/published and judges what they wrote: see published.sh, which calls this."""
import argparse
import csv
import dataclasses
import json
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # here and in the programs that Strake calls: the same bits everywhere
try:
    import numpy as np
    import scipy  # noqa: F401
except ImportError:
    print("skipped: needs python3-numpy and python3-scipy")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parent.parent
CASES = ROOT / "cases/published"
sys.path.insert(0, str(CASES))
import areas  # noqa: E402
import cone  # noqa: E402
import lattice  # noqa: E402
import newton  # noqa: E402
import newton_hull  # noqa: E402
import nose  # noqa: E402
import stokes  # noqa: E402
import surfaces  # noqa: E402
import trefftz  # noqa: E402
import wing_body_flow  # noqa: E402


class Row:
    """A number that is published, and ours. `why`: the place of docs/published.md that explains a miss; such a miss is told, and no failure."""

    def __init__(self, what, published, value, passed, digits=5, why=None):
        self.what, self.published, self.value, self.digits, self.why = what, published, float(value), digits, why
        self.passed = None if passed is None else bool(passed)  # None: shown, not judged

    def words(self):
        return f"{self.value:.{self.digits}g}"

    def verdict(self):
        if self.passed is False:
            return f"**missed**, [why](#{self.why})" if self.why else "**missed**"
        return "met" if self.passed else "not judged"


def wave_drag(kind):
    def judge(run):
        found = areas.judge(run / "best.obj", kind)
        return [Row("drag over the least", "1, within 0.5 %", 1 + found["excess"], abs(found["excess"]) < 0.005, 6),
                Row("largest error of S over largest S", "0, within 1 %", found["area_error"], found["area_error"] < 0.01, 2)]
    return judge


def span_efficiency(lift, at_start):
    """From the load itself: e = 1 / sum n (A_n / A_1)^2 of its sine series, on a lattice with twice as many strips."""
    def efficiency(vertices, triangles, moved, alpha):
        lattice.divide(4, 48)
        places, area, _ = lattice.lattice_points(vertices)
        wing = lattice.Lattice((lattice.sheet(vertices, triangles, places) @ moved).reshape(5, 49, 3), alpha)
        t = np.pi / 2 * (1 - (np.arange(48) + 0.5) / 48)  # pi/2 at the root, 0 at the tip
        n = np.arange(1, 96, 2)
        A = np.sin(np.outer(n, t)) @ wing.last
        lift = wing.wake()[0][0] / area
        lattice.divide(4, 24)
        return float(1 / np.sum(n * (A / A[0]) ** 2)), lift

    def judge(run):
        vertices, triangles = lattice.read_obj(surface_of(run))
        moved = lattice.read_obj(run / "best.obj")[0]
        rows = history(run)
        first = float(rows[0]["wing.efficiency"])
        e, cl = efficiency(vertices, triangles, moved, float(best_row(rows)["alpha"]))
        return [Row("span efficiency at the start", f"{at_start}, within 0.001", first, abs(first - at_start) < 0.001, 4),
                Row("span efficiency", "1, at least 0.999", e, 0.999 <= e < 1.0005),
                Row("lift coefficient", f"{lift}, within 1 %", cl, abs(cl / lift - 1) < 0.01, 4),
                Row("evaluations", "at most 10", len(rows), len(rows) <= 10, 3)]
    return judge


def nonplanar_wing(run):
    """The written wing on a lattice of other strips than the run's, and the least drag of its wake by a program of its own."""
    vertices, triangles = lattice.read_obj(surface_of(run))
    moved = lattice.read_obj(run / "best.obj")[0]
    alpha = float(best_row(history(run))["alpha"])
    lattice.divide(8, 48)
    places, area, aspect = lattice.lattice_points(vertices)
    wing = lattice.Lattice((lattice.sheet(vertices, triangles, places) @ moved).reshape(9, 49, 3), alpha)
    (lift, *_), (drag, *_) = wing.wake()
    lattice.divide(4, 24)
    e = lift**2 / (math.pi * aspect * area * drag)
    span = 2 * moved[:, 1].max()
    height = np.ptp(moved[:, 2]) / 10
    best = trefftz.min_drag_of_half(wing.edge, 300) * (wing.edge[:, 0].max() / 5) ** 2
    return [Row("span efficiency", "winglets 1.4186; at least 1.35", e, e >= 1.35),
            Row("that over the best load's on its wake", "1, no more", e / best, e < 1.002 * best),  # else the lattice is exploited
            Row("span", "10, no more", span, span <= 10 + 1e-6),
            Row("height over span", "0.2, no more", height, height <= 0.2 + 1e-6),
            Row("lift coefficient", "0.5, within 2 %", lift / area, abs(lift / area / 0.5 - 1) < 0.02, 4)]


def spheroid(aspect):
    """Drag along its axis of a prolate spheroid over that of the sphere of its volume (Oberbeck 1876)."""
    e = math.sqrt(1 - aspect**-2)
    over_half_length = 8 / 3 * e**3 / ((1 + e * e) * math.log((1 + e) / (1 - e)) - 2 * e)
    return over_half_length * aspect ** (2 / 3)


def tip_angle(run):
    """Mean of both ends, in degrees: of the slope of the radius, from areas of sections, over 0.5 to 2 % of the length."""
    vertices, triangles = areas.read_obj(run / "best.obj")
    begin, end = vertices[:, 0].min(), vertices[:, 0].max()
    angles = []
    for tip, way in ((begin, 1), (end, -1)):
        d = (end - begin) * np.linspace(0.005, 0.02, 7)
        r = [math.sqrt(areas.section_area(vertices[triangles], tip + way * x) / math.pi) for x in d]
        angles.append(math.degrees(math.atan(np.polyfit(d, r, 1)[0])))
    return sum(angles) / 2


def stokes_drag(run):
    start, best = (areas.read_obj(p) for p in (surface_of(run), run / "best.obj"))
    ratio = stokes.Body(*best).drag() / stokes.Body(*start).drag() * (areas.volume(*start) / areas.volume(*best)) ** (1 / 3)
    best_spheroid = min(spheroid(a) for a in np.arange(1.8, 2.1, 0.001))
    return [Row("drag over the sphere's", f"0.95425; best spheroid {best_spheroid:.5f}; at most 0.9555", ratio, 0.953 < ratio <= 0.9555),
            Row("semi-angle of the ends, degrees", "60", tip_angle(run), None, 3)]


def surface_area(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def spheroid_of_area(aspect):
    """Drag along its axis of a prolate spheroid over that of the sphere of its area."""
    e = math.sqrt(1 - aspect**-2)
    area = aspect ** (-2 / 3) * (1 + aspect * math.asin(e) / e) / 2  # over the sphere's of the same volume
    return spheroid(aspect) / math.sqrt(area)


def stokes_drag_of_area(run):
    start, best = (areas.read_obj(p) for p in (surface_of(run), run / "best.obj"))
    ratio = stokes.Body(*best).drag() / stokes.Body(*start).drag() * math.sqrt(surface_area(*start) / surface_area(*best))
    best_spheroid = min(spheroid_of_area(a) for a in np.arange(3.8, 4.3, 0.01))
    return [Row("drag over the sphere's", f"0.887, within 0.1 %; best spheroid {best_spheroid:.4f}", ratio, abs(ratio / 0.887 - 1) < 0.001),
            Row("semi-angle of the ends, degrees", "30.8", tip_angle(run), None, 3)]


FLOW_CELLS = (160, 240)  # on the length


def flow_ratios(run, by_area_rule, is_free):
    """Of the drags of start and result by Euler's equations, which the area rule knows nothing of, on two meshes. Coarse cells add the
    same false drag to both, so that ratios are too near one, and less so on the finer mesh. Not judged of a free body, whose areas by
    the rule are not those of the flow."""
    wing, folder = areas.read_obj(CASES / "generated/wing_panels.obj"), str(run / "flow")
    shown, before = [], 1.0
    for cells in FLOW_CELLS:
        found = [wing_body_flow.drag(folder, areas.read_obj(body), wing, 1.4, cells) for body in (surface_of(run), run / "best.obj")]
        ratio = found[0][1] / found[1][1]
        is_nearer = abs(ratio / by_area_rule - 1) < abs(before / by_area_rule - 1)
        is_met = is_nearer and abs(ratio / by_area_rule - 1) < 0.15
        shown.append(Row(f"drag of the start over ours by Euler's equations, {found[1][0]} cells",
                         f"by the area rule {by_area_rule:.4g}" + ("" if is_free else ", within 15 %; nearer with each mesh"), ratio,
                         None if is_free else is_met, 4))
        before = ratio
    shutil.rmtree(folder)
    return shown


def wing_body(mach, is_free=False):
    def judge(run):
        wing = CASES / "generated/wing_panels.obj"
        first, last = (areas.judge_wing_body(body, wing, mach, rolls=48) for body in (surface_of(run), run / "best.obj"))
        ratio = last["drag"] / last["least"]
        rows = [Row("drag over the lower bound, at the start", "", first["drag"] / first["least"], None, 4),
                Row("of the Sears-Haack body beside the wing", "", last["sears_haack_beside_wing"], None, 5)]
        if is_free:
            rows.append(Row("drag over the lower bound of bodies of revolution", "1, no more", ratio, 0.5 < ratio <= 1))
        else:
            rows.append(Row("drag over the lower bound", "1, within 2 %", ratio, 0.995 < ratio < 1.02))
        if mach > 1 and shutil.which("rhoCentralFoam") and shutil.which("snappyHexMesh"):
            rows += flow_ratios(run, first["drag"] / last["drag"], is_free)
        elif mach > 1:
            print("wing_body: drags not confirmed by a flow, OpenFOAM is not installed: scripts/setup.sh openfoam")
        return rows
    return judge


def newton_resistance(run):
    found = newton.judge(run / "best.obj")
    by_facets, by_rings = (found[name] / found["least"] for name in ("resistance", "revolved"))
    nose, best = found["nose"], found["best_nose"]
    return [Row("resistance", f"{found['least']:.6f}, within 0.1 %", found["resistance"], abs(by_facets - 1) < 0.001, 7),
            Row("that of the body revolved", f"{found['least']:.6f}, within 0.1 %", found["revolved"], abs(by_rings - 1) < 0.001, 7),
            Row("radius of the flat nose", f"{best:.5f}, within 0.005", nose, abs(nose - best) < 0.005),
            Row("slope at its edge", "1", found["slope_at_nose"], None, 3),
            Row("least bend of the profile, radians", "0 or more: concave", found["min_bend"], found["min_bend"] > -1e-9, 2)]


POLYGONS = {0.4: (6, 2.103366, 2.09965), 0.7: (4, 1.556653, 1.54553), 1: (3, 1.156092, 1.13778), 1.5: (2, 0.701874, 0.70097),
            2: (2, 0.445753, None)}  # corners, resistance, the least that is known


def hull_resistance(height):
    """Of the hull that the run found, on a disc of four times as many corners."""
    corners, published, known = POLYGONS[height]

    def judge(run):
        found = newton_hull.points_of({name: float(value) for name, value in best_row(history(run)).items()
                                       if re.fullmatch("[xyz][0-9]+", name)})
        value = newton_hull.resistance(found, 2880)[0]
        polygon = newton_hull.best_polygon(height, corners)
        beside = f"{known}, the least known" if known else ""
        return [Row("resistance of the polygon's hull", f"{published}, within 1e-5", polygon, abs(polygon / published - 1) < 1e-5, 7),
                Row("resistance", f"{published}, no more; {beside}".rstrip("; "), value, value <= published, 7),
                Row("over that of Newton's own body", "", value / newton.least(height)[0], None)]
    return judge


EXPONENTS = (0.6, 0.64, 0.68, 0.72, 0.76)


def best_power(drags):
    """Exponent and drag at the least of the parabola through the best of EXPONENTS and those beside it."""
    k = min(max(int(np.argmin(drags)), 1), len(drags) - 2)
    a, b, c = np.polyfit(np.array(EXPONENTS[k - 1:k + 2]) - EXPONENTS[k], drags[k - 1:k + 2], 2)
    return EXPONENTS[k] - b / (2 * a), c - b * b / (4 * a)


def nose_drag(mach, exponent):
    """Cone, power-law bodies and the written body by the same solver; the best ones also on a mesh half as fine again."""
    def judge(run):
        def drag(surface, factor=1.0):
            return nose.drag(run / "judge", surface, mach, factor)

        def power(n):
            made = surfaces.nose(n, 4000)
            return np.array(made.vertices), np.array(made.triangles)
        exact, of_cone = cone.pressure_coefficient(mach, math.atan(1 / 6)), drag(power(1))
        n, least = best_power([drag(power(k)) for k in EXPONENTS])
        best, rows = areas.read_obj(run / "best.obj"), history(run)
        free = drag(best)
        finer = drag(best, 1.5) / drag(power(n), 1.5)
        return [Row("drag of the cone", f"{exact:.6f}, within 2 %", of_cone, abs(of_cone / exact - 1) < 0.02),
                Row("best exponent of the power-law bodies", exponent, n, abs(n - 0.68) <= 0.02, 3, "supersonic-nose" if mach < 5 else None),
                Row("drag of that body", "", least, None),
                Row("drag of ours", "", free, None),
                Row("ours over the best power-law body's", "1, no more", free / least, free <= least),
                Row("the same on a mesh 1.5 times as fine", "1, no more", finer, finer <= 1),
                Row("runs of the solver", "at most 15", len(rows), len(rows) <= 15, 3)]
    return judge


def duct_losses(run):
    """By the solver's own words, for the start and the written walls."""
    def losses(surface):
        return float(subprocess.run([CASES / "sbend.py", "losses", surface], cwd=run, check=True, stdout=subprocess.PIPE, text=True).stdout)
    start, best, rows = losses(surface_of(run)), losses(run / "best.obj"), history(run)
    a, b = (areas.read_obj(p)[0] for p in (surface_of(run), run / "best.obj"))
    return [Row("losses at the start", "7.17675e-7, within 0.01 %", start, abs(start / 7.17675e-7 - 1) < 1e-4, 6),
            Row("losses", "6.40740e-7; at most 6.41e-7", best, best <= 6.41e-7, 6),
            Row("largest displacement", "0.0796, no more", np.linalg.norm(b - a, axis=1).max(), np.linalg.norm(b - a, axis=1).max() <= 0.0797, 4),
            Row("flows with their adjoints", "5", len(rows), len(rows) <= 5, 3)]


FINER, LIFTS = "1.26", ("0.24", "0.29", "0.34")  # twice the cells
BOXES = ("6x8x2", "4x4x2")  # points along chord, span and height


def lines_by_hand(*paths):
    """What somebody had to write: lines that are neither blank nor comments."""
    lines = [line.strip() for path in paths for line in path.read_text(encoding="utf-8").splitlines()]
    return sum(bool(line) and not line.startswith(("#", "//")) for line in lines)


def child_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def transonic_polar(run, surface):
    """Drags at LIFTS on a mesh of twice the cells; NaN where the flow does not settle."""
    (run / "judge").mkdir(exist_ok=True)
    drags = []
    for lift in LIFTS:
        told = subprocess.run([CASES / "transonic/m6.py", "polar", FINER, surface, lift], cwd=run / "judge", check=False,
                              stdout=subprocess.PIPE, text=True).stdout
        found = re.findall(r"drag ([0-9.]+)", told)
        drags.append(float(found[0]) if found else math.nan)
    return drags


def transonic_rows(run, fine):
    rows = history(run)
    first, last = float(rows[0]["objective"]), float(best_row(rows)["objective"])
    return [Row("drag at the start, counts", "", 1e4 * first, None, 4),
            Row("drag", f"less than {1e4 * first:.1f}", 1e4 * last, last < first, 4),
            Row("on a mesh of twice the cells, start", "", 1e4 * fine[0][1], None, 4),
            Row("the same, ours", f"less than {1e4 * fine[0][1]:.1f}", 1e4 * fine[1][1],
                None if math.isnan(fine[1][1]) else fine[1][1] < fine[0][1], 4),
            Row("runs of the solver", "", len(rows), None, 3)]


def bests_of(trace):
    """The best so far after each evaluation, of a box by bench/wings."""
    with open(trace, encoding="utf-8", newline="") as file:
        return [float(row["best"]) for row in csv.DictReader(file)]


def transonic_drag(run):
    """Against boxes of B-splines by the same search (bench/wings), where that is built; all on a mesh of twice the cells, at three lifts."""
    fine = transonic_polar(run, surface_of(run)), transonic_polar(run, run / "best.obj")
    shown, count, last = transonic_rows(run, fine), len(history(run)), float(best_row(history(run))["objective"])
    wings = pathlib.Path(os.environ["STRAKE"]).parent.parent / "bench/wings/strake_wings"
    if not wings.exists():
        print(f"transonic: not compared with boxes, {wings} is not built")
        return shown
    polars = {"ours": fine[1]}
    for box in BOXES:
        shutil.rmtree(CASES / "runs/transonic", ignore_errors=True)  # where it keeps the flows
        before = child_seconds()
        subprocess.run([wings, CASES / "transonic.yaml", "--only-boxes", "--boxes", box, "--values-only", "--set", "optimize.method=model",
                        "--budget", str(count), "--reach", "0.026", "--out", run / "box"], cwd=run, check=True)
        seconds = child_seconds() - before
        found = bests_of(run / f"box/transonic-box_{box}.csv")[-1]
        by_box = polars[f"the box's of {box}"] = transonic_polar(run, run / f"box/transonic-box_{box}.obj")
        shown += [Row(f"drag by a box of {box} points that twists", "", 1e4 * found, None, 4),
                  Row("seconds of CPU of that", "", seconds, None, 4),
                  Row("ours over that drag", "1, no more", last / found, last <= found),
                  Row("the same on a mesh of twice the cells", "1, no more", fine[1][1] / by_box[1],
                      None if math.isnan(by_box[1]) else fine[1][1] <= by_box[1])]
    for k, lift in enumerate(LIFTS):
        shown += [Row(f"there at lift {lift}, {who} over the start's", "", drags[k] / fine[0][k], None, 4) for who, drags in polars.items()]
    return shown + [Row("lines written by hand, of the case", "", lines_by_hand(CASES / "transonic.yaml"), None, 4),
                    Row("of the box, beside the case", "", lines_by_hand(ROOT / "bench/wings/wing_box.cpp"), None, 4)]


def surface_of(run):
    text = (run / "case.yaml").read_text(encoding="utf-8")
    return (run / re.search(r"file: *\"?([^\s\"},]+)", text).group(1)).resolve()


def history(run):
    with open(run / "history.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def best_row(rows):
    return min((r for r in rows if r["status"] == "ok" and float(r["max_violation"]) <= 1e-6), key=lambda r: float(r["objective"]))


@dataclasses.dataclass
class Problem:
    start: str  # surface
    triangles: int
    judge: object
    source: str
    case: str = None  # another one's than of this name, on this start surface
    quick: int = None  # evaluations of the quick run, where it has fewer
    beside: str = None  # a second surface, of 2000 triangles
    settings: tuple = ()
    is_slow: bool = False  # left out of the quick run
    needs: str = None  # a program without which there is nothing to judge
    prepare: str = None  # a program of cases/published that makes the start surface, with words before "prepare"


PROBLEMS = {
    "sears_haack": Problem("bumped_spindle", 10000, wave_drag("volume"), "Haack 1941, Sears 1947: D/q = 128 V²/(π L⁴)"),
    "haack": Problem("bumped_spindle", 10000, wave_drag("diameter"), "Haack 1941: D/q = 4π S²/L²"),
    "karman": Problem("bumped_ogive", 10000, wave_drag("base"), "von Kármán 1935: D/q = 4 S²/(π L²)"),
    **{f"newton_{height}": Problem(f"frustum_{height}", 10000, newton_resistance, "Newton 1687", case="newton")
       for height in (0.4, 0.7, 1, 1.5, 2)},
    **{f"newton_hull_{height}": Problem("newton_hull", 352, hull_resistance(height), "Lachand-Robert and Oudet 2005; Wachsmuth 2013",
                                        case=f"generated/newton_hull_{height}", is_slow=True, prepare=f"newton_hull.py {height}")
       for height in (0.4, 0.7, 1, 1.5, 2)},
    "wing_body_1": Problem("bumped_spindle", 10000, wing_body(1.0), "area rule: see below", case="wing_body", beside="wing_panels",
                           is_slow=True),
    "wing_body_1.4": Problem("bumped_spindle", 10000, wing_body(1.4), "area rule: see below", case="wing_body", beside="wing_panels",
                             settings=("quantities.drag.mach=1.4", "quantities.drag.angles=16"), is_slow=True),
    "wing_body_free": Problem("bumped_spindle", 10000, wing_body(1.4, is_free=True), "area rule: see below", beside="wing_panels",
                              is_slow=True),
    "nose_2": Problem("nose_0.75", 4000, nose_drag(2.0, "0.68, within 0.02"), "Taylor and Maccoll 1933; Mason and Lee 1994", case="nose",
                      is_slow=True, needs="rhoCentralFoam"),
    "nose_6": Problem("nose_0.75", 4000, nose_drag(6.0, "0.68, within 0.02"), "Taylor and Maccoll 1933; Mason and Lee 1994", case="nose",
                      settings=("quantities.newton.mach=6", 'quantities.flow.command=[./nose.py, "6", "{request}", "{result}"]'),
                      is_slow=True, needs="rhoCentralFoam"),
    "sbend": Problem("sbend", 1280, duct_losses, "OpenFOAM's tutorial, by its own optimizer", is_slow=True, needs="adjointOptimisationFoam",
                     prepare="sbend.py"),
    "transonic": Problem("onera_m6", 6000, transonic_drag, "AGARD AR-138; an expert's box", is_slow=True, needs="rhoSimpleFoam",
                         prepare="transonic/m6.py"),
    "stokes": Problem("sphere", 2000, stokes_drag, "Pironneau 1973; Montenegro-Johnson and Lauga 2014", quick=14),
    "stokes_area": Problem("sphere", 2000, stokes_drag_of_area, "Montenegro-Johnson and Lauga 2014", case="stokes", is_slow=True,
                           settings=("constraints={area: {equals: 1, relative: true}}", "quantities.drag.on_failure=shrink_step")),
    "twist_10": Problem("wing_10", 2000, span_efficiency(0.5, 0.960), "Munk 1921; start: OpenAeroStruct's example"),
    "twist_6_12": Problem("wing_6_12", 2000, span_efficiency(0.375, 0.983), "Munk 1921; start: ADODG case 3"),
    "nonplanar": Problem("wing_raised", 2000, nonplanar_wing, "Prandtl 1924, Kroo 2005; values by trefftz.py", is_slow=True),
}


def write(kind, triangles, path):
    surfaces.KINDS[kind](triangles).write(path.with_suffix(".part"))
    path.with_suffix(".part").replace(path)


def run_problem(name, options):
    """None: its start surface cannot be made."""
    problem = PROBLEMS[name]
    budget = options.budget or (problem.quick if options.quick else None)
    surface = CASES / "generated" / f"{problem.start}.obj"
    surface.parent.mkdir(exist_ok=True)
    if problem.prepare:
        program, *words = problem.prepare.split()
        if subprocess.run([CASES / program, *words, "prepare"], check=False).returncode != 0:
            return None  # it has said why
    else:
        write(problem.start, problem.triangles, surface)
    if problem.beside:
        write(problem.beside, 2000, CASES / "generated" / f"{problem.beside}.obj")
    run = options.out / name
    shutil.rmtree(run, ignore_errors=True)
    command = [options.bin / "strake", "run", CASES / f"{problem.case or name}.yaml", "--out", run, "-q"]
    if problem.case:
        command += ["--set", f"surface.file={surface}"]
    for setting in problem.settings:
        command += ["--set", setting]
    if budget:
        command += ["--set", f"optimize.budget.evaluations={budget}"]
    before = child_seconds()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    seconds = child_seconds() - before
    # 3: the budget is spent, or no step is left: what was found counts
    if not (run / "best.obj").exists():
        print(done.stdout)
        return name, problem.triangles, [Row(f"the run ended with status {done.returncode}", "a design", math.nan, False)], 0, 0, problem.source
    return name, problem.triangles, problem.judge(run), len(history(run)), seconds, problem.source


def tables(results):
    lines = ["| problem | triangles | what | published | ours | | evaluations | seconds of CPU |", "|---|---|---|---|---|---|---|---|"]
    for name, triangles, rows, evaluations, seconds, _ in results:
        for k, row in enumerate(rows):
            first = [f"`{name}`", str(triangles)] if k == 0 else ["", ""]
            last = [str(evaluations), f"{seconds:.0f}"] if k == 0 else ["", ""]
            lines.append("| " + " | ".join(first + [row.what, row.published, row.words(), row.verdict()] + last) + " |")
    return "\n".join(lines)


def merged(table, results):
    """The page's table with the rows of these problems in the place of what it had of them, in the order of PROBLEMS."""
    rows, name = {}, None
    for line in table.strip().split("\n")[2:] + tables(results).split("\n")[2:]:
        first = re.match(r"\| `([^`]+)`", line)
        if first:
            name = first[1]
            rows[name] = []
        rows[name].append(line)
    order = [n for n in PROBLEMS if n in rows]
    return "\n".join(tables([]).split("\n") + [line for n in order for line in rows[n]])


def main():
    parser = argparse.ArgumentParser(description="Problems with published answers.")
    parser.add_argument("--write", action="store_true", help="the table of docs/published.md: the rows of those that are run")
    parser.add_argument("--quick", action="store_true", help="those that take seconds, fewer evaluations of Stokes flow")
    parser.add_argument("--budget", type=int, help="evaluations of each run, to try the command")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/published", help="folder of the runs")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/programs", help="folder of strake")
    parser.add_argument("names", nargs="*", help=", ".join(PROBLEMS))
    options = parser.parse_args()
    unknown = [n for n in options.names if n not in PROBLEMS]
    if unknown:
        parser.error(f"no problem is called {unknown[0]}; there are {', '.join(PROBLEMS)}")
    if options.write and (options.budget or options.quick):
        parser.error("--write needs problems at their full size")
    options.out.mkdir(parents=True, exist_ok=True)
    options.out, options.bin = options.out.resolve(), options.bin.resolve()
    os.environ["STRAKE"] = str(options.bin / "strake")  # for programs that call it: not another one on PATH
    results, is_complete = [], True
    for name in options.names or [n for n in PROBLEMS if not (options.quick and PROBLEMS[n].is_slow)]:
        if PROBLEMS[name].needs and not shutil.which(PROBLEMS[name].needs):
            print(f"{name}: not run, {PROBLEMS[name].needs} is not installed: scripts/setup.sh openfoam")
            is_complete = False
            continue
        result = run_problem(name, options)
        if result is None:
            print(f"{name}: not run, its start surface is not there: scripts/setup.sh openfoam")
            is_complete = False
            continue
        results.append(result)
        print(tables(results[-1:]).split("\n", 2)[2], flush=True)
    (options.out / "results.json").write_text(json.dumps(
        [{"problem": r[0], "triangles": r[1], "evaluations": r[3], "seconds": r[4],
          "rows": [{"what": row.what, "published": row.published, "ours": row.value, "met": row.passed, "explained": row.why is not None} for row in r[2]]}
         for r in results], indent=1), encoding="utf-8")
    if options.write:
        page = ROOT / "docs/published.md"
        text = page.read_text(encoding="utf-8")
        begin, end = "<!-- results -->\n", "<!-- end of results -->"
        head, rest = text.split(begin)
        table, rest = rest.split(end)
        page.write_text(head + begin + "\n" + merged(table, results) + "\n\n" + end + rest, encoding="utf-8")
    sys.exit(0 if is_complete and all(row.passed is not False or row.why for r in results for row in r[2]) else 1)


if __name__ == "__main__":
    main()
