"""Seeded mistakes in the case file, the surface, the command line and the environment: each is answered by one message
that says where, what, which limit and what to do, and by the exit status that belongs to it.

The messages stand in tests/cli/mistakes.txt as they are printed, to be read. `mistakes_test.py STRAKE --show` prints
what the program says now."""
import contextlib
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
STRAKE = pathlib.Path(sys.argv[1]).resolve()


def body(rings=8, sectors=16):
    """Vertices and faces (from 0) of an ellipsoid 2 x 1.2 x 0.8."""
    points = [(-1, 0, 0)]
    for i in range(1, rings):
        a = math.pi * i / rings
        points += [(-math.cos(a), 0.6 * math.sin(a) * math.cos(b), 0.4 * math.sin(a) * math.sin(b))
                   for b in (2 * math.pi * k / sectors for k in range(sectors))]
    points.append((1, 0, 0))
    ring = lambda i, k: 1 + (i - 1) * sectors + k % sectors
    faces = [(0, ring(1, k + 1), ring(1, k)) for k in range(sectors)]
    for i in range(1, rings - 1):
        for k in range(sectors):
            faces += [(ring(i, k), ring(i, k + 1), ring(i + 1, k)), (ring(i, k + 1), ring(i + 1, k + 1), ring(i + 1, k))]
    faces += [(ring(rings - 1, k), ring(rings - 1, k + 1), len(points) - 1) for k in range(sectors)]
    return points, faces


def obj(points, faces):
    return "".join("v %r %r %r\n" % p for p in points) + "".join("f %d %d %d\n" % tuple(v + 1 for v in f) for f in faces)


POINTS, FACES = body()
BODY = obj(POINTS, FACES)
HALF = obj([(x, 0.0 if abs(y) < 1e-9 else y, z) for x, y, z in POINTS],
           [face for face in FACES if all(POINTS[v][1] > -1e-9 for v in face)])
CASE = """case: body
surface: {file: body.obj}
regions:
  nose: {box: [[-2, -1, -1], [-0.7, 1, 1]]}
fixed: [nose]
shell: {thickness: 10%}
parameters: {patches_per_level: [2], variables: [normal]}
objective: {maximize: volume}
constraints: {area: {max: 1.01, relative: true}}
optimize: {budget: {evaluations: 2}}
"""


def case(*changes):
    """The case with (old, new) replaced, or a line appended."""
    text = CASE
    for change in changes:
        if isinstance(change, str):
            text += change + "\n"
        else:
            assert change[0] in text, change
            text = text.replace(*change)
    return text


def program(script):
    return {"solver.sh": "#!/bin/sh\n" + script + "\n", "case.yaml": case(
        ("objective: {maximize: volume}", 'quantities:\n  cfd: {command: [./solver.sh, "{result}"], gradients: false}\n'
         "objective: {minimize: cfd}"), ("evaluations: 2}", "evaluations: 2}, method: cobyla"))}


def with_gradients(files):
    return {**files, "case.yaml": files["case.yaml"].replace(", gradients: false", "").replace(", method: cobyla", "")}


# (title, files beside body.obj and case.yaml, arguments, exit status); the messages are in mistakes.txt.
CHECK, RUN = ["check", "case.yaml"], ["run", "case.yaml", "--out", "runs"]
MISTAKES = [
    # The case file.
    ("a misspelled key", {"case.yaml": case(("objective:", "objektive:"))}, RUN, 2),
    ("a misspelled method", {"case.yaml": case(("optimize: {", "optimize: {method: slqsp, "))}, CHECK, 2),
    ("a key twice", {"case.yaml": case("fixed: []")}, CHECK, 2),
    ("a tab", {"case.yaml": case(("  nose:", "\tnose:"))}, CHECK, 2),
    ("a decimal comma", {"case.yaml": case(("parameters: {patches_per_level: [2], variables: [normal]}", "parameters:\n  max_displacement: 1,5%"))}, CHECK, 2),
    ("an angle without its unit", {"case.yaml": case(("patches_per_level: [2]", "levels: [20, 10]"))}, CHECK, 2),
    ("a length in millimetres of nobody knows what",
     {"case.yaml": case(("variables:", "max_displacement: 5 mm, variables:"))}, CHECK, 2),
    ("a region that is not declared", {"case.yaml": case(("fixed: [nose]", "fixed: [nsoe]"))}, CHECK, 2),
    ("a region where nothing is", {"case.yaml": case(("[-0.7, 1, 1]", "[-1.5, 1, 1]"))}, CHECK, 2),
    ("corners of a box the wrong way round", {"case.yaml": case(("[[-2, -1, -1], [-0.7, 1, 1]]", "[[-0.7, 1, 1], [-2, -1, -1]]"))}, CHECK, 2),
    ("nothing to optimize", {"case.yaml": case(("objective: {maximize: volume}\n", ""))}, RUN, 2),
    ("limits that exclude each other", {"case.yaml": case(("max: 1.01", "min: 1.02, max: 1.01"))}, CHECK, 2),
    ("a start outside of its bounds", {"case.yaml": case("variables: {alpha: {start: 9deg, min: 0deg, max: 6deg}}")}, CHECK, 2),
    ("an unknown quantity in a formula", {"case.yaml": case(("maximize: volume", 'maximize: "volume / aera"'))}, CHECK, 2),
    ("a surface that is not there", {"case.yaml": case(("body.obj", "boddy.obj"))}, CHECK, 2),
    ("a solver that is not there",
     {"case.yaml": case(("objective: {maximize: volume}", "quantities: {cfd: {command: [./run_cfd.sh]}}\nobjective: {minimize: cfd}"))}, CHECK, 2),
    ("an alias that contains itself", {"case.yaml": case("loads: &a [*a]")}, CHECK, 2),
    ("a case in UTF-16", {"case.yaml": CASE.encode("utf-16")}, CHECK, 2),
    ("a plane of symmetry where the surface is closed", {"case.yaml": case("symmetry: {plane: y, at: 0}")}, CHECK, 2),
    ("a method that needs gradients, and a program without",
     {"solver.sh": "#!/bin/sh\n", "case.yaml": case(("objective: {maximize: volume}",
      "quantities: {cfd: {command: [./solver.sh], gradients: false}}\nobjective: {minimize: cfd}"),
      ("optimize: {", "optimize: {method: sqp, "))}, CHECK, 2),
    ("an objective that is a word of the trade", {"case.yaml": case(("maximize: volume", "minimize: drag"))}, CHECK, 2),
    ("a type in place of a quantity", {"case.yaml": case(("maximize: volume", "minimize: wave_drag"))}, CHECK, 2),
    ("a body that flies backwards, said twice",
     {"case.yaml": case(("objective: {maximize: volume}", "axes: {downstream: +x, up: +z}\nquantities:\n"
      "  aero: {type: newtonian, mach: 6, forward: [-1, 0, 0]}\nobjective: {minimize: aero.drag}"))}, CHECK, 2),
    ("axes that are not square", {"case.yaml": case("axes: {downstream: +x, up: [1, 0, 1]}")}, CHECK, 2),
    ("a shell thicker than the world", {"case.yaml": case(("thickness: 10%", "thickness: 1e200"))}, CHECK, 2),
    ("a formula without a value at the start", {"case.yaml": case(("maximize: volume", 'minimize: "log(area - area)"'))}, CHECK, 1),
    ("a limit that limits nothing", {"case.yaml": case(("variables: [normal]", "variables: [normal], max_displacement: 3"))}, CHECK, 0),
    # The surface.
    ("half a body, and no word of it", {"body.obj": HALF}, CHECK, 3),
    ("half a body, to be measured along its length", {"body.obj": HALF, "case.yaml": case(
        ("objective: {maximize: volume}", "quantities: {w: {type: wave_drag}}\nobjective: {minimize: w}"))}, CHECK, 2),
    ("a hole, where a volume is asked for", {"body.obj": obj(POINTS, FACES[3:])}, CHECK, 3),
    ("a part that nothing holds", {"case.yaml": case(("fixed: [nose]", "fixed: []"))}, CHECK, 1),
    ("a fin that forks the skin", {"body.obj": obj(POINTS + [(0, 0, 1)], FACES + [(40, 41, len(POINTS))])}, CHECK, 3),
    ("a triangle without area", {"body.obj": obj(POINTS, FACES + [(5, 5, 6)])}, CHECK, 3),
    ("a face that names a vertex too many", {"body.obj": BODY + "f 1 2 9999\n"}, ["info", "body.obj"], 3),
    ("half a binary STL", {"half.stl": b"\0" * 80 + (100).to_bytes(4, "little") + b"\0" * 700}, ["info", "half.stl"], 3),
    ("a CAD file", {"body.step": "ISO-10303-21;\n"}, ["init", "body.step", "-o", "new.yaml"], 3),
    ("an empty file", {"empty.stl": ""}, ["info", "empty.stl"], 3),
    ("coordinates beyond all measure", {"big.obj": BODY + "v 1e300 0 0\nf 1 2 %d\n" % (len(POINTS) + 1)}, ["info", "big.obj"], 3),
    ("a target with other triangles, to be matched vertex by vertex",
     {"target.obj": obj(*body(6, 12)), "case.yaml": case(("objective: {maximize: volume}",
      "quantities: {t: {type: target_shape, file: target.obj, match: same}}\nobjective: {minimize: t}"))}, CHECK, 2),
    # The command line.
    ("a misspelled command", {}, ["rum", "case.yaml"], 2),
    ("a misspelled option", {}, ["run", "case.yaml", "--ou", "runs"], 2),
    ("a key of the case as an option", {}, ["run", "case.yaml", "--evaluations", "20"], 2),
    ("a surface in place of the case", {}, ["run", "body.obj"], 2),
    ("a case in place of the surface", {}, ["info", "case.yaml"], 3),
    ("a word of the trade to explain", {}, ["explain", "drag"], 2),
    ("a run that is not there, to apply", {}, ["apply", "nowhere", "body.obj", "-o", "new.obj"], 2),
    ("no case", {}, ["run"], 2),
    ("an angle beyond ninety degrees", {}, ["patches", "body.obj", "--angle", "95"], 2),
    ("a repair that asks for nothing", {}, ["repair", "body.obj", "-o", "new.obj"], 2),
    ("a fill without holes", {}, ["repair", "body.obj", "-o", "new.obj", "--orient", "--fill", "smooth"], 2),
    ("two rules for the parts", {}, ["repair", "body.obj", "-o", "new.obj", "--components", "largest=1", "--components", "largest=2"], 2),
    ("an option in the place of a value", {}, ["repair", "body.obj", "--weld", "-o", "new.obj"], 2),
    ("a shortest edge longer than the edges", {}, ["remesh", "body.obj", "-o", "new.obj", "--edge-length", "5%", "--shortest-edge", "500%"], 2),
    ("an output of unknown format", {}, ["repair", "body.obj", "-o", "new.step", "--orient"], 2),
    ("a variable that is not there", {}, ["sweep", "case.yaml", "--variable", "p1.load_norm", "--from", "0", "--to", "1", "--steps", "2"], 2),
    ("a run that is not there", {}, ["resume", "nowhere"], 2),
    ("a case in the way", {}, ["init", "body.obj", "-o", "case.yaml"], 2),
    ("a key asked for by the wrong name", {}, ["explain", "optimizer.method"], 2),
    ("a level that is not there", {}, ["check", "case.yaml", "--level", "7"], 2),
    ("an empty name of a folder", {}, ["run", "case.yaml", "--out", ""], 2),
    ("a setting without a value", {}, ["run", "case.yaml", "--set", "optimize.budget.evaluations"], 2),
    ("a setting of no key", {}, ["check", "case.yaml", "--set", "optimize.bugdet.evaluations=3"], 2),
    ("a setting of the wrong kind", {}, ["check", "case.yaml", "--set", "fixed[0]=[tail]"], 2),
    ("the folder of a run in place of its case", {"old/case.yaml": "", "old/journal.sqlite": ""}, ["run", "old"], 2),
    ("a case in place of the folder of its run", {}, ["resume", "case.yaml"], 2),
    ("a sphere that holds no triangle", {"case.yaml": case(
        ("nose: {box: [[-2, -1, -1], [-0.7, 1, 1]]}", "nose: {sphere: {center: [-1, 0, 0], radius: 0.02}}"))}, CHECK, 2),
    ("a force that a half model does not have", {"body.obj": HALF, "case.yaml": case(
        ("{area: {max: 1.01, relative: true}}", "{aero.side: {max: 1}}"), "symmetry: {plane: y}",
        "quantities: {aero: {type: newtonian, mach: 6}}")}, CHECK, 2),
    ("a surface of one triangle", {"body.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"}, ["init", "body.obj", "-o", "new.yaml"], 2),
    # The environment.
    ("results in the way", {"runs/old.txt": "precious\n"}, RUN, 4),
    ("a file where a folder should be", {"runs": "a file\n"}, ["run", "case.yaml", "--out", "runs/one"], 4),
    ("a folder in place of a surface", {"body.obj/x": ""}, ["info", "body.obj"], 3),
    ("a full disk", {}, ["info", "body.obj", "--json"], 4),
    ("a solver that fails", program("echo mesh generation failed >&2; exit 3"), RUN, 5),
    ("a solver that leaves no result", program("exit 0"), RUN, 5),
    ("a solver that writes nonsense", program('echo "drag = 0.5" > "$1"'), RUN, 5),
    ("a solver whose answer is no number", program('echo \'{"value": "0.5"}\' > "$1"'), RUN, 5),
    ("a solver whose value is nothing", program('echo \'{"value": null}\' > "$1"'), RUN, 5),
    ("a solver that answers with a number", program('echo 0.5 > "$1"'), RUN, 5),
    ("a solver that gives values only", with_gradients(program('echo \'{"value": 0.5}\' > "$1"')), RUN, 5),
    ("a solver that gives a number alone", with_gradients(program('echo 0.5 > "$1"')), RUN, 5),
    ("a solver that calls its value another name", with_gradients(program('echo \'{"drag": 0.5}\' > "$1"')), RUN, 5),
    ("a solver that may not be run", {**program("exit 0"), "mode": 0o644}, RUN, 2),
    ("a script beside the case, which the program looks for where it runs",
     {"solve.py": "", "points.csv": "", "case.yaml": program("")["case.yaml"].replace(
         "./solver.sh", "python3, solve.py, points.csv, \"{case_dir}/solve.py\"")},
     CHECK, 0),
]


def write(folder, files):
    for name, content in files.items():
        if name == "mode":
            continue
        path = folder / name
        if path.parent != folder:
            if path.parent.is_file():
                path.parent.unlink()
            path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        if name.endswith(".sh"):
            path.chmod(files.get("mode", 0o755))


def answer(files, arguments, title):
    """Exit status and standard error, with the folder cut away."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write(folder, {"body.obj": BODY, "case.yaml": CASE})
        write(folder, files)
        out = open("/dev/full", "w") if title == "a full disk" else subprocess.DEVNULL
        with contextlib.ExitStack() as stack:
            if out is not subprocess.DEVNULL:
                stack.enter_context(out)
            done = subprocess.run([STRAKE, *arguments], cwd=folder, stdin=subprocess.DEVNULL, stdout=out,
                                  stderr=subprocess.PIPE, timeout=60, env={**os.environ, "LC_ALL": "C"})
        text = done.stderr.decode().replace(str(folder) + "/", "").replace(name, "")
    # Lines of progress come before the message.
    lines = [line for line in text.splitlines() if not re.match(r"strake: reading |level  patches|level \d|note: ", line)]
    return done.returncode, "\n".join(lines)


def listing():
    out = ""
    for title, files, arguments, expected in MISTAKES:
        status, words = answer(files, arguments, title)
        out += "%s\n$ strake %s    [%d%s]\n%s\n\n" % (title[0].upper() + title[1:], " ".join(arguments), status,
                                                    "" if status == expected else ", should be %d" % expected,
                                                    re.sub("^", "  ", words, flags=re.M))
    return out


def main():
    said = listing()
    if "--show" in sys.argv:
        print(said, end="")
        return 0
    expected = (HERE / "mistakes.txt").read_text()
    failures = []
    if len(MISTAKES) < 40:
        failures.append("only %d mistakes" % len(MISTAKES))
    for is_, was in zip(said.split("\n\n"), expected.split("\n\n")):
        if is_ != was:
            failures.append("it says\n%s\nand should say\n%s" % (is_, was))
        # What no stranger can act on.
        for jargon in ("std::", "basic_", "stoi", "bad_alloc", "exception", "assert", "terminate", "nan", "0x", "internal error"):
            if jargon in is_:
                failures.append("jargon '%s' in\n%s" % (jargon, is_))
        if "should be" in is_.splitlines()[1] if len(is_.splitlines()) > 1 else False:
            failures.append("wrong exit status:\n" + is_)
        if len(is_.splitlines()) > 22:
            failures.append("too long:\n" + is_)
    if said.count("\n\n") != expected.count("\n\n"):
        failures.append("%d mistakes, the list has %d" % (said.count("\n\n"), expected.count("\n\n")))
    print("\n\n".join(failures) or "%d mistakes, each answered" % len(MISTAKES))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
