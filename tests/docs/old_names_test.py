"""No old name outside of the table of aliases and its tests: old_names_test.py [ROOT]

Names of several words are taken apart, so that `promisedGain` and `promised_gain` are both found; comments are not looked at, nor are names of
one word (a slot of a wing, a credit to an author). Keys are looked for in the cases of the examples and in the blocks of the documentation.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["bench", "casefile", "cases", "cli", "core", "include", "objectives", "optimize", "python", "report", "scripts", "studio",
           "tests", "viewer"]
CODE = {".cpp", ".hpp", ".h", ".py", ".js", ".mjs"}
OLD_WORDS = re.compile(r" (doubt(s|ed|ful)?|dear|own variables?|given variables?|calm|stuck|so far|promis(e|es|ed|ing)|outlook|credits?|"
                       r"sureness|border belief|left out|nearly held|gapes?|going on|given up|stands for failure|most|least|lee|"
                       r"points reach|split share|associations) ")
NOT_OLD = re.compile(r" (at (most|least)|least (squares?|distance)|await promise) ")
OLD_KEY = re.compile(r"(?<![\w.])(gives|wanted|freeze|points_reach|associations|promise_below|split_share|core|growth|lee|layer):"
                     r"|\[load_normal\]|method: slsqp")
ALIASES = {"casefile/schema/renamed.cpp", "tests/casefile/renamed_test.cpp", "tests/docs/old_names_test.py"}
# Keys of run folders and of --json, which stay.
KEPT = re.compile(r'"left_out"|"levels_left_out"|"nearly_held"|\bleft_out: left\b')


def words_of(name):
    return " " + " ".join(re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)).lower() + " "


def old_in_code(text, suffix):
    text = KEPT.sub("", text)
    text = re.sub(r"(?m)//.*$" if suffix != ".py" else r"(?m)#.*$", "", text)
    found = []
    for name in sorted(set(re.findall(r"\b\w*[A-Za-z]\w*\b", text))):
        words = NOT_OLD.sub(" . ", words_of(name))
        if OLD_WORDS.search(words) and (name.count("_") > 0 or re.search("[a-z][A-Z]", name)):
            found.append(name)
    return found


def old_in_case(text):
    return [match.group(0) for match in OLD_KEY.finditer(re.sub(r"(?m)(^|\s)#.*$", "", text))]


def blocks(page):
    return "\n".join(re.findall(r"```yaml\n(.*?)```", page, re.S))


def main():
    problems = []
    if old_in_code("int promised_gain, thePromisedGain, at_least_one, degrees_of_freedom;", ".cpp") != ["promised_gain", "thePromisedGain"]:
        problems.append("the check of code does not tell old names from new ones")
    if old_in_case("parameters: {split_share: 80%, marking_fraction: 1}  # growth: 2") != ["split_share:"]:
        problems.append("the check of cases does not tell old keys from new ones")
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            name = path.relative_to(ROOT).as_posix()
            if name in ALIASES or "/node_modules/" in name or "/generated/" in name or name.startswith("tests/casefile/of_0_1/"):
                continue
            if path.suffix in CODE:
                problems += [f"{name}: {old}" for old in old_in_code(path.read_text(encoding="utf-8", errors="replace"), path.suffix)]
            elif path.suffix in (".yaml", ".yml") and folder == "cases":
                problems += [f"{name}: {old}" for old in old_in_case(path.read_text(encoding="utf-8"))]
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        problems += [f"{path.relative_to(ROOT)}: {old}" for old in old_in_case(blocks(path.read_text(encoding="utf-8")))]
    print("\n".join(problems) or "no old name is left")
    return 1 if problems else 0


sys.exit(main())
