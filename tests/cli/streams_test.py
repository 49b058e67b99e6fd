"""What goes where, and when: JSON alone on standard output, no colours but on terminals, a first line at once, an end
report with its machine-readable copy, help at no cost. Arguments: the programs strake and make_surface."""
import json
import os
import pathlib
import pty
import re
import resource
import select
import subprocess
import sys
import tempfile
import time
import unittest

STRAKE, MAKE_SURFACE = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:3])
CASE = """
case: streams
surface: {file: body.obj}
regions: {root: {box: [[-9, -9, -9], [0.8, 9, 9]]}}
fixed: [root]
parameters: {levels: auto, patches_per_level: [2], variables: [normal], max_displacement: 2%}
objective: {maximize: volume}
constraints: {area: {max: 1.01, relative: true}}
optimize: {budget: {evaluations: 4}}
"""
FIT = """case: fit
surface: {file: body.obj}
fixed: [root]
regions: {root: {box: [[-9, -9, -9], [0.8, 9, 9]]}}
parameters: {levels: auto, patches_per_level: [2], variables: [normal], max_displacement: 2%}
quantities: {match: {type: target_shape, file: moved.obj, match: same}}
fit: [match]
optimize: {budget: {evaluations: 2}}
"""
BENT = CASE.split("parameters:")[0].replace("fixed: [root]", "fixed: [root]\nloads: [{region: tail, displacement: 1%, direction: [0, 0, 1]}]") \
    .replace("regions: {", "regions: {tail: {box: [[6, -9, -9], [99, 9, 9]]}, ")
# Every command that has --json, in an order in which each finds what it needs.
JSON = [["info", "body.obj"], ["repair", "body.obj", "-o", "mended.obj", "--orient"],
        ["remesh", "body.obj", "-o", "even.obj", "--edge-length", "10%"], ["patches", "body.obj", "--angle", "20"],
        ["init", "body.obj", "-o", "new.yaml"], ["deform", "bent.yaml", "-o", "bent.obj"], ["check", "case.yaml"],
        ["run", "case.yaml", "--out", "run"], ["status", "run"], ["history", "run"], ["resume", "run", "--evaluations", "+1"],
        ["sample", "case.yaml", "-n", "3", "--out", "sampled"],
        ["schema"], ["explain", "objective"], ["gradient-check", "case.yaml"],
        ["sweep", "case.yaml", "--variable", "p1.load_normal", "--from", "0", "--to", "0.1", "--steps", "2"],
        ["apply", "run", "body.obj", "-o", "moved.obj"], ["compare", "body.obj", "moved.obj"],
        ["mix", "run", "body.obj", "--weight", "0.5", "-o", "mixed.obj"]]

# The others that print, and what is asked of the program as a whole.
WORDS = [["studio", "body.obj", "--no-browser"], ["history", "run"], ["history", "run", "--csv"], ["fit", "fit.yaml", "--out", "fitted"], ["step", "stepped.yaml", "--json"],
         ["report", "run", "-o", "page.html"], ["completion", "bash"], ["man"], ["--help"], ["--version"], ["run", "--help"]]


def said(*arguments, **environment):
    return subprocess.run([STRAKE, *arguments], cwd=FOLDER, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=120, check=False, env={**os.environ, **environment})


def setUpModule():
    global SCRATCH, FOLDER
    SCRATCH = tempfile.TemporaryDirectory()
    FOLDER = pathlib.Path(SCRATCH.name)
    subprocess.run([MAKE_SURFACE, "lifting_body", "--triangles", "1500", "-o", "body.obj"], cwd=FOLDER, check=True,
                   stdout=subprocess.DEVNULL)
    (FOLDER / "case.yaml").write_text(CASE)
    (FOLDER / "bent.yaml").write_text(BENT)


def tearDownModule():
    SCRATCH.cleanup()


class Streams(unittest.TestCase):
    def test_json_alone_is_on_standard_output(self):
        with_json = set()
        for command in re.findall(r"^  ([a-z-]+) {2,}", said("--help").stdout.split("Subcommands:")[1].split("Exit statuses")[0], re.M):
            if "--json" in said(command, "--help").stdout:
                with_json.add(command)
        tried = {row[0] for row in JSON}
        # fit and step answer as run does: of the same function.
        self.assertEqual(with_json - tried - {"fit", "step"}, set(), "commands with --json that are not tried here")
        for arguments in JSON:
            done = said(*arguments, "--json")
            self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
            self.assertTrue(json.loads(done.stdout), arguments)  # all of it is one value
            self.assertNotIn("\x1b", done.stdout + done.stderr)
        broken = said("check", "none.yaml", "--json")
        self.assertEqual(broken.returncode, 2)
        self.assertEqual(json.loads(broken.stdout)["status"], "error")
        failing = said("info", "none.obj", "--json")
        self.assertEqual((failing.returncode, failing.stdout), (3, ""))
        self.assertIn("none.obj", failing.stderr)

    def test_a_full_disk_for_what_is_printed_is_told_by_every_command(self):
        commands = set(re.findall(r"^  ([a-z-]+) {2,}", said("--help").stdout.split("Subcommands:")[1].split("Exit statuses")[0], re.M))
        rows = [[*row, *more] for row in JSON for more in ([], ["--json"])] + WORDS
        self.assertEqual(commands - {row[0] for row in rows}, set(), "commands that are not tried here")
        self.assertEqual(said("run", "case.yaml", "--out", "shown").returncode, 0)
        for name in ("mended", "even", "bent", "moved"):
            (FOLDER / f"{name}.obj").write_bytes((FOLDER / "body.obj").read_bytes())
        (FOLDER / "fit.yaml").write_text(FIT)
        (FOLDER / "stepped.yaml").write_text(CASE + "output: {dir: stepped}\n")
        for number, row in enumerate(rows):
            # What is made must not be there yet; the run that is looked at is.
            row = [{"new.yaml": f"new{number}.yaml", "fitted": f"fitted{number}"}.get(word, word) for word in row]
            if row[0] in ("run", "sample") and "--out" in row:
                row[row.index("--out") + 1] = f"full{number}"
            else:
                row[1:] = ["shown" if word == "run" else word for word in row[1:]]
            with open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run([STRAKE, *row], cwd=FOLDER, stdin=subprocess.DEVNULL, stdout=full, stderr=subprocess.PIPE,
                                      text=True, timeout=120, check=False)
            self.assertEqual(done.returncode, 4, f"{row}: {done.stderr}")
            self.assertIn("standard output: cannot write: No space left on device", done.stderr, row)

    def test_no_colour_anywhere_even_on_a_terminal(self):
        for environment in ({}, {"NO_COLOR": "1"}):
            for arguments in (["--help"], ["info", "body.obj"], ["check", "case.yaml"], ["rum"],
                              ["run", "case.yaml", "--out", "coloured" + str(len(environment))]):
                ours, theirs = pty.openpty()
                child = subprocess.Popen([STRAKE, *arguments], cwd=FOLDER, stdin=subprocess.DEVNULL, stdout=theirs,
                                         stderr=theirs, env={**os.environ, "TERM": "xterm-256color", **environment})
                os.close(theirs)
                seen = b""
                try:
                    while more := os.read(ours, 65536):
                        seen += more
                except OSError:
                    pass  # the other end is closed
                child.wait(timeout=60)
                os.close(ours)
                self.assertGreater(len(seen), 20)
                self.assertIsNone(re.search(rb"\x1b\[[0-9;]*m", seen), (arguments, seen[:200]))

    def test_the_first_line_comes_at_once(self):
        child = subprocess.Popen([STRAKE, "run", "case.yaml", "--out", "first"], cwd=FOLDER, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE)
        begin = time.monotonic()
        ready, _, _ = select.select([child.stderr], [], [], 30)
        waited = time.monotonic() - begin
        words = child.stderr.read().decode()
        child.wait(timeout=60)
        child.stderr.close()
        self.assertTrue(ready)
        self.assertLess(waited, 3, words)  # one second is promised; machines that test are busy
        rows = re.findall(r"^ +1 +\d+ +\d+ +\d+ +[\d.e+-]+ +[\d.e+-]+ ", words, re.M)
        self.assertGreaterEqual(len(rows), 3, words)  # level, evaluation, objective, violation: a row each

    def test_the_end_tells_what_changed_and_a_program_can_read_it(self):
        done = said("run", "case.yaml", "--out", "told")
        self.assertEqual(done.returncode, 0, done.stderr)
        for row in (r"^status +\w+$", r"^reason +\S", r"^evaluations +\d+, on 1 levels", r"^volume +[\d.e+-]+ -> [\d.e+-]+ \(",
                    r"^area +[\d.e+-]+ -> ", r"^moved +at most [\d.e+-]+ % of the diagonal", r"^files +told: .*best\.obj",
                    r"^view +paraview told/series\.pvd"):
            self.assertRegex(done.stdout, re.compile(row, re.M))
        copy = json.loads((FOLDER / "told/run.json").read_text())
        told = re.search(r"^volume +([\d.e+-]+) -> ([\d.e+-]+)", done.stdout, re.M)
        self.assertAlmostEqual(copy["values"]["volume"]["best"], float(told[2]), delta=1e-6 * abs(float(told[2])))
        self.assertEqual(copy["status"], re.search(r"^status +(\w+)$", done.stdout, re.M)[1])

    def test_a_poor_environment_is_enough(self):
        def poor():
            for limit, value in ((resource.RLIMIT_NOFILE, 40), (resource.RLIMIT_STACK, 4 << 20)):
                resource.setrlimit(limit, (value, value))
            os.umask(0o077)
            for descriptor in (0, 1, 2):
                os.close(descriptor)

        child = subprocess.Popen([STRAKE, "run", FOLDER / "case.yaml", "--out", FOLDER / "poor"], preexec_fn=poor,
                                 env={"TMPDIR": "/nowhere"}, cwd="/")
        self.assertEqual(child.wait(timeout=120), 0)
        self.assertEqual((FOLDER / "poor/history.csv").read_bytes(), (FOLDER / "told/history.csv").read_bytes()
                         if (FOLDER / "told").exists() else (FOLDER / "poor/history.csv").read_bytes())
        self.assertEqual((FOLDER / "poor/best.obj").stat().st_mode & 0o077, 0)

    def test_help_and_version_cost_nothing(self):
        """By the pages of memory that they touch, which do not depend on what else the machine does."""
        def pages(*arguments):
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_minflt
            done = said(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertTrue(done.stdout)
            return resource.getrusage(resource.RUSAGE_CHILDREN).ru_minflt - before

        works = pages("check", "case.yaml")
        for arguments in (["--version"], ["--help"], ["run", "--help"], ["completion", "bash"]):
            self.assertLess(pages(*arguments), works / 3, arguments)  # a fifth, most of it libraries


unittest.main(argv=sys.argv[:1], verbosity=1)
