#!/usr/bin/python3
"""Runs the examples under cases/ and counts suspicions of their gradients, all of which are right: check_verdicts.py BIN [--evaluations N]
[--triangles N] [--only PART] [--out FOLDER]
or counts those of the tests: check_verdicts.py --tests PROGRAM...

BIN holds strake and make_surface. Left out are the cases with OpenFOAM and those that deform or fit. A run accuses a gradient where its
status is `gradient_inconsistent`, and suspects it where its reason names a wrong gradient; both count. N evaluations a run at most (default
60), N triangles of the larger surfaces (default 2000).
With --tests gdb counts searches and accusations while each program of tests runs; tests that give wrong gradients on purpose
(WRONG) are told apart.
Exit status: 0 no gradient is accused or suspected and every run has a verdict, 1 else, 2 wrong usage.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


# What these tests give as a gradient is wrong, also beside right ones.
WRONG = re.compile(r"^All/WrongGradients\.\w+/(?!none$|large_constant$)|^WrongDerivativesByParameters\.|"
                   r"^SlopeCheck\.(ABudgetThat|WhatLongStepsHide|AFactor|AFlippedSign|AGradientThatIsZero|AZeroGradient|AtABound)|"
                   r"^Verdict\.(AWrongGradient|TheConstraintWithTheWrong)|^RunVerdict\.AGradientThatContradicts")


def count_tests(programs):
    """Per test the searches, the runs and the accusations, in the order of the output: gdb prints at each."""
    places = {"conclude_run": "run", "check_slopes": "search", "SlopeCheck::accuse": "accused"}
    counts, per_test, failed = dict.fromkeys(places.values(), 0), {}, 0
    for program in programs:
        names = subprocess.run(["nm", "-C", program], check=True, capture_output=True, text=True).stdout
        at = []
        for place, word in places.items():
            found = re.search(rf"^([0-9a-f]+) [tT] strake::(?:\(anonymous namespace\)::)?{place}\([^\n]*\)$", names, re.M)
            if found:
                at.append((found[1], word))
        base = ["-ex", "starti"]  # addresses are those of the file once it is loaded without randomization
        where = [f"dprintf *(0x{address} + 0x555555554000), \"\\n@{word}\\n\"" for address, word in at]
        commands = [argument for line in where for argument in ("-ex", line)]
        done = subprocess.run(["gdb", "-q", "-batch", "-nx", *base, *commands, "-ex", "continue", program],
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                              errors="replace", check=False)
        test = ""
        for line in done.stdout.splitlines():
            if line.startswith("[ RUN      ] "):
                test = line[13:]
            elif line.startswith("[  FAILED  ] ") and " ms)" in line:
                failed += 1
            elif line.startswith("@") and line[1:] in counts:
                counts[line[1:]] += 1
                per_test.setdefault(test, dict.fromkeys(counts, 0))[line[1:]] += 1
    wrongly = {test: seen["accused"] for test, seen in per_test.items() if seen["accused"] > 0 and not WRONG.search(test)}
    meant = {test: seen["accused"] for test, seen in per_test.items() if seen["accused"] > 0 and WRONG.search(test)}
    for test, number in sorted(meant.items()):
        print(f"wrong on purpose: {test}: {number} accused")
    for test, number in sorted(wrongly.items()):
        print(f"ACCUSED: {test}: {number}")
    print(f"{len(per_test)} tests with searches: {counts['run']} runs, {counts['search']} searches whose gradients were looked at, "
          f"{counts['accused']} accused, {sum(wrongly.values())} of them in tests whose gradients are right; {failed} tests failed")
    return 1 if wrongly or counts["search"] == 0 else 0


def is_run(text):
    return re.search(r"^objective:", text, re.M) is not None


def verdict_of(case, run, strake):
    done = subprocess.run([strake, "run", case, "--out", run, "--quiet"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True, check=False)
    try:
        with open(os.path.join(run, "run.json"), encoding="utf-8") as file:
            return json.load(file)
    except OSError:
        return {"status": f"exit {done.returncode}", "reason": done.stderr.strip(), "evaluations": 0}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", nargs="?")
    parser.add_argument("--tests", nargs="+", metavar="PROGRAM")
    parser.add_argument("--evaluations", type=int, default=60)
    parser.add_argument("--triangles", type=int, default=2000)
    parser.add_argument("--only", default="")
    parser.add_argument("--out")
    args = parser.parse_args()
    if bool(args.bin) == bool(args.tests):
        parser.error("either BIN or --tests PROGRAM...")
    if args.tests:
        return count_tests(args.tests)
    programs, work = os.path.abspath(args.bin), args.out or tempfile.mkdtemp()
    cases = os.path.join(work, "cases")
    shutil.copytree(os.path.join(ROOT, "cases"), cases, dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns("generated", "openfoam*", "geometry"))
    for folder in ("openfoam_drag", "openfoam_supersonic", "openfoam_wing"):  # examples.sh makes their surfaces, too
        os.makedirs(os.path.join(cases, "external", folder), exist_ok=True)
    subprocess.run([os.path.join(ROOT, "scripts/examples.sh"), cases, programs, str(args.triangles), str(args.triangles)],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    runs, accused, suspected, without = 0, 0, 0, 0
    for folder, _, files in sorted(os.walk(cases)):
        for name in sorted(files):
            path = os.path.join(folder, name)
            if not name.endswith(".yaml") or args.only not in path:
                continue
            with open(path, encoding="utf-8") as file:
                text = file.read()
            if not is_run(text):
                continue
            text = re.sub(r"(evaluations: *)(\d+)", lambda m: m[1] + str(min(int(m[2]), args.evaluations)), text)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            shown = os.path.relpath(path, cases)
            run = os.path.join(work, "runs", shown[:-5].replace(os.sep, "_"))
            result = verdict_of(path, run, os.path.join(programs, "strake"))
            runs += 1
            is_accused = result["status"] == "gradient_inconsistent"
            accused += is_accused
            suspected += not is_accused and "wrong gradient" in result["reason"]
            without += result["status"].startswith("exit")
            print(f"{shown}: {result['status']}, {result['evaluations']} evaluations: {result['reason'].splitlines()[0]}", flush=True)
    print(f"{runs} runs, {accused} accuse a gradient, {suspected} suspect one, {without} without a verdict")
    return 1 if accused + suspected + without > 0 or runs == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
