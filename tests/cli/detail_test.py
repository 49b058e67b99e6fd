"""`-v` and `--debug` of every command: more words on standard error, never on standard output. Arguments: the programs
strake and make_surface."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

STRAKE, MAKE_SURFACE = (str(pathlib.Path(p).resolve()) for p in sys.argv[1:3])
CASE = """
case: detail
surface: {file: wing.obj}
regions: {root: {box: [[-1, -1, -1], [3, 0.2, 1]]}}
fixed: [root]
symmetry: {plane: y, at: 0}
parameters: {levels: auto, patches_per_level: [2], variables: [normal], max_displacement: 2%}
objective: {maximize: volume}
constraints: {area: {max: 1.001, relative: true}}
optimize: {budget: {evaluations: 2}}
"""


def said(folder, *arguments):
    return subprocess.run([STRAKE, *map(str, arguments)], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=120, check=False)


class Detail(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        subprocess.run([MAKE_SURFACE, "wing", "--triangles", "1000", "-o", "wing.obj"], cwd=cls.folder, check=True,
                       stdout=subprocess.DEVNULL)
        (cls.folder / "case.yaml").write_text(CASE)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_every_command_takes_them(self):
        commands = re.findall(r"^  ([a-z-]+) {2,}",
                              said(self.folder, "--help").stdout.split("Subcommands:")[1].split("Exit statuses")[0], re.M)
        self.assertGreaterEqual(len(commands), 20)
        for command in commands:
            words = said(self.folder, command, "--help").stdout
            self.assertRegex(words, r"-v,\s*--verbose", command)
            self.assertIn("--debug", words, command)

    def test_more_words_go_to_standard_error_only(self):
        for arguments in (["info", "wing.obj"], ["info", "wing.obj", "--json"], ["check", "case.yaml", "--json", "--quick"],
                          ["patches", "wing.obj", "--angle", "20"], ["explain", "objective"]):
            plain, more = said(self.folder, *arguments), said(self.folder, *arguments, "-v")
            self.assertEqual(plain.returncode, 0, plain.stderr)
            self.assertEqual(plain.stdout, more.stdout, arguments)
            self.assertEqual(more.returncode, 0)
            steps = more.stderr[len(plain.stderr):] if more.stderr.startswith(plain.stderr) else more.stderr
            self.assertRegex(steps, r"(?m)^strake: +\d+\.\d\d s  strake \d+\.\d+", arguments)
            self.assertRegex(steps, r"(?m)^strake: .* ends with status 0: [\d.]+ s, [\d.]+ s of CPU time", arguments)
            self.assertNotIn("\x1b", more.stderr)
            if arguments[0] == "info":
                self.assertRegex(more.stderr, r"wing\.obj: \d+ vertices, \d+ triangles")
                self.assertNotIn("reading", plain.stderr)

    def test_a_run_tells_every_value_of_every_evaluation(self):
        plain = said(self.folder, "run", "case.yaml", "--out", "plain", "--json")
        more = said(self.folder, "run", "case.yaml", "--out", "more", "--json", "-v")
        self.assertEqual(more.returncode, 0, more.stderr)
        self.assertEqual(json.loads(plain.stdout)["objective"], json.loads(more.stdout)["objective"])
        self.assertRegex(more.stderr, r"evaluation 1: [\d.e-]+ s, volume = [\d.e-]+, area = [\d.e-]+")
        self.assertIn("problem: ", more.stderr)
        self.assertEqual((self.folder / "plain/history.csv").read_bytes(), (self.folder / "more/history.csv").read_bytes())

    def test_debug_says_what_an_error_was(self):
        for arguments, status, kind in ((["info", "none.stl"], 3, "strake::InputError"),
                                        (["check", "none.yaml"], None, "strake::"),
                                        (["deform", "case.yaml"], 2, ""),
                                        (["run", "case.yaml", "--out", "wing.obj"], 4, "strake::OutputError")):
            plain, more = said(self.folder, *arguments), said(self.folder, *arguments, "--debug")
            self.assertEqual(plain.returncode, more.returncode)
            if status is not None:
                self.assertEqual(more.returncode, status, more.stderr)
            self.assertNotIn("debug:", plain.stderr)
            if not kind:
                continue  # the command line's own mistakes have nothing inside them
            self.assertRegex(more.stderr, r"(?m)^debug: thrown +%s" % kind)
            for row in ("last step", "program", "machine", "command line", "cost"):
                self.assertRegex(more.stderr, r"(?m)^debug: %s +\S" % row)
            self.assertIn("[--debug]", more.stderr)
            self.assertEqual(more.stdout, plain.stdout)

    def test_names_are_printed_harmlessly(self):
        name = "a \x1b[31mred\nname"
        more = said(self.folder, "info", name, "-v", "--debug")
        self.assertEqual(more.returncode, 3)
        self.assertNotIn("\x1b", more.stderr)
        bad = os.fsencode("x") + b"\xff\xfe.stl"
        done = subprocess.run([STRAKE.encode(), b"info", bad, b"-v", b"--debug"], cwd=self.folder, capture_output=True,
                              check=False)
        self.assertEqual(done.returncode, 3)
        self.assertNotIn(b"\xff", done.stderr)

    def test_nothing_without_an_error(self):
        self.assertEqual(said(self.folder, "info", "wing.obj").stderr, said(self.folder, "info", "wing.obj", "--debug").stderr)


unittest.main(argv=sys.argv[:1], verbosity=1)
