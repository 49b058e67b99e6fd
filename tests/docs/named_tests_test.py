"""Every test that docs/promises.md and docs/reliability.md name exists: named_tests_test.py [ROOT]

Names are `Suite.Name`, `Instance/Suite.Name`, `Suite.*`, and `.Name` for another one of the suite before.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if len(sys.argv) > 1 else ROOT.parents[2]
TEST = re.compile(r"^\s*(?:TYPED_)?TEST(?:_[FP])?\((\w+),\s*(\w+)\)", re.M)
INSTANCE = re.compile(r"INSTANTIATE_TEST_SUITE_P\((\w+),\s*(\w+)")
NAMED = re.compile(r"(?:(\w+)/)?([A-Z]\w+)\.([A-Z]\w+|\*)")


def missing(page, tests, instances):
    """The names on a page that no test has."""
    suites, found, before = {suite for suite, _ in tests}, [], ""
    for word in re.findall(r"`([^`\n]+)`", page):
        named = NAMED.fullmatch(before + word if word.startswith(".") else word)
        if not named:
            continue
        instance, suite, name = named.groups()
        before = suite
        exists = suite in suites if name == "*" else (suite, name) in tests
        if not exists or instance and (instance, suite) not in instances:
            found.append(named.group(0))
    return found


def main():
    tests, instances = set(), set()
    for path in (ROOT / "tests").rglob("*.?pp"):
        text = path.read_text(encoding="utf-8")
        tests.update(TEST.findall(text))
        instances.update(INSTANCE.findall(text))
    problems = [] if missing("`Guard.NobodyWroteThis` `NoSuite.*`", tests, instances) == ["Guard.NobodyWroteThis", "NoSuite.*"] else [
        "the check lets names pass that no test has"]
    for page in ("promises.md", "reliability.md"):
        text = (ROOT / "docs" / page).read_text(encoding="utf-8")
        problems += ["docs/%s: there is no test %s" % (page, name) for name in missing(text, tests, instances)]
    print("\n".join(problems) or "every test that is named exists")
    return 1 if problems else 0


sys.exit(main())
