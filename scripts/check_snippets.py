#!/usr/bin/env python3
"""Runs what README.md and docs/*.md tell people to type: check_snippets.py BIN

- ```sh blocks run in order, page by page, in a fresh copy of the cases, with BIN (strake, make_surface) on the PATH;
  the examples' surfaces are small ones. Lines that start `./run.sh` or `./test.sh` are not run here (this script is
  part of test.sh, which runs the same job in its step "main job"): the script and the case named must exist.
- ```yaml blocks that are whole cases (they have the keys `case` and `surface`) go through `strake check`, in the
  page's folder; other ones that begin with a key of a case are held against `strake schema --json`, where python3-yaml
  and python3-jsonschema are installed.
- ```python blocks of a page run as one program after its other blocks, where BIN/python holds the Python module.
- Blocks that wrap a dirty body are skipped, and counted, where the program has no alpha wrap (-DSTRAKE_GPL=OFF).
Other fences (text, console, cpp) are output or code for reading. Exit status 1 if anything fails.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
SECONDS_PER_BLOCK = 300


def blocks(page):
    text = page.read_text(encoding="utf-8")
    for match in FENCE.finditer(text):
        yield text.count("\n", 0, match.start()) + 1, match.group(1), match.group(2)


def fresh_copy(folder, bin_folder):
    """The repository as a reader sees it, without builds; example surfaces at a size that keeps this cheap."""
    for name in ("cases", "scripts", "include"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("generated", "*.cpp", "*.hpp"))
    for name in ("run.sh", "test.sh", "README.md"):
        shutil.copy2(ROOT / name, folder / name)
    subprocess.run([ROOT / "scripts/examples.sh", folder / "cases", bin_folder, "6000", "6000"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def split_covered(code, where, failures):
    """Takes out the lines that call run.sh or test.sh, after a look at what they name."""
    kept = []
    for line in code.splitlines():
        words = line.split("#")[0].split()
        if not words or words[0] not in ("./run.sh", "./test.sh"):
            kept.append(line)
            continue
        for name in words:
            if not (ROOT / name).is_file():
                failures.append(f"{where}: '{line.strip()}' names {name}, which does not exist")
    return "\n".join(kept)


def run(command, where, folder, environment, failures, text=None):
    try:
        done = subprocess.run(command, cwd=folder, env=environment, input=text, text=True, timeout=SECONDS_PER_BLOCK,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    except subprocess.TimeoutExpired:
        failures.append(f"{where}: not done after {SECONDS_PER_BLOCK} s")
        return
    if done.returncode != 0:
        tail = "\n    ".join(done.stdout.splitlines()[-15:])
        failures.append(f"{where}: exit status {done.returncode}\n    {tail}")


def has_wrap(bin_folder):
    licenses = subprocess.run([str(bin_folder / "strake"), "--licenses"], check=True, text=True, stdout=subprocess.PIPE).stdout
    return "no part under the GPL" not in licenses


def fragment_checker(bin_folder):
    """What is wrong with a part of a case, by its JSON Schema: keys may be missing, but none may be unknown or mistaken."""
    try:
        import jsonschema
        import yaml
    except ImportError:
        return lambda code: []

    class Loader(yaml.SafeLoader):
        """As yaml-cpp reads: `on` is a word, 8e5 a number."""

    Loader.yaml_implicit_resolvers = {
        first: [(tag, form) for tag, form in forms if not tag.endswith((":bool", ":float"))]
        for first, forms in yaml.SafeLoader.yaml_implicit_resolvers.items()}
    Loader.add_implicit_resolver("tag:yaml.org,2002:bool", re.compile("true|false"), list("tf"))
    Loader.add_implicit_resolver("tag:yaml.org,2002:float", re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.I),
                                 list("-+.0123456789"))
    schema = json.loads(subprocess.run([str(bin_folder / "strake"), "schema", "--json"], check=True,
                                       stdout=subprocess.PIPE).stdout)
    schema.pop("required", None)
    validator = jsonschema.Draft7Validator(schema)
    return lambda code: [f"{'.'.join(map(str, e.absolute_path))}: {e.message[:200]}"
                         for e in validator.iter_errors(yaml.load(code, Loader))]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    bin_folder = pathlib.Path(sys.argv[1]).resolve()
    environment = dict(os.environ, PATH=f"{bin_folder}{os.pathsep}{os.environ['PATH']}")
    failures, counts, skipped = [], {"sh": 0, "yaml": 0, "python": 0}, []
    can_wrap = has_wrap(bin_folder)
    wrong_in = fragment_checker(bin_folder)
    module = bin_folder / "python"
    has_module = any(module.glob("strake/_core*"))
    with tempfile.TemporaryDirectory() as temporary:
        pristine = pathlib.Path(temporary) / "pristine"
        pristine.mkdir()
        fresh_copy(pristine, bin_folder)
        for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
            folder = pathlib.Path(temporary) / "-".join(page.relative_to(ROOT).with_suffix("").parts)
            shutil.copytree(pristine, folder)
            program = []
            for line, kind, code in blocks(page):
                where = f"{page.relative_to(ROOT)}:{line}"
                if not can_wrap and kind == "sh" and re.search(r"^wrap:", code, re.M):
                    skipped.append(where)
                    continue
                if kind in ("sh", "bash", "shell"):
                    counts["sh"] += 1
                    code = split_covered(code, where, failures)
                    if code.strip():
                        run(["bash", "-euo", "pipefail", "-s"], where, folder, environment, failures, code)
                elif kind == "python":
                    counts["python"] += 1
                    program.append(code)
                elif kind == "yaml" and re.search(r"^case:", code, re.M) and re.search(r"^surface:", code, re.M):
                    counts["yaml"] += 1
                    snippet = folder / f"snippet_{line}.yaml"
                    snippet.write_text(code, encoding="utf-8")
                    run([str(bin_folder / "strake"), "check", str(snippet)], where, folder, environment, failures)
                elif kind == "yaml" and code[0].isalpha():
                    counts["yaml"] += 1
                    failures += [f"{where}: {words}" for words in wrong_in(code)]
            if program and has_module:
                run(["/usr/bin/python3", "-"], f"{page.relative_to(ROOT)} (python)", folder,
                    dict(environment, PYTHONPATH=str(module)), failures, "\n".join(program))
    print(f"{counts['sh']} shell blocks, {counts['yaml']} cases and {counts['python']} blocks of Python"
          f"{'' if has_module else ' (not run: BIN/python has no module)'} in the documentation, {len(failures)} failures")
    if skipped:
        print(f"{len(skipped)} skipped, this build has no alpha wrap: {', '.join(skipped)}")
    print(*failures, sep="\n")
    if not counts["sh"]:
        failures.append("no shell block found")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
