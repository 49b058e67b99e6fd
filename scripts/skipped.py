#!/usr/bin/python3
"""How many tests did not run, and why: skipped.py LastTest.log (of ctest). One line a reason."""

import collections
import re
import sys


def main():
    with open(sys.argv[1], encoding="utf-8", errors="replace") as log:
        words = log.read()
    reasons = collections.Counter()
    for test in re.split(r"^-{20,}\n(?=\d+/\d+ Test(?:ing)?: )", words, flags=re.M)[1:]:
        name = re.match(r"\d+/\d+ Test(?:ing)?: (\S+)", test).group(1)
        # Cases of GoogleTest, each with its reason in front.
        for reason in re.findall(r": Skipped\n(.*)\n(?:\n)*\[  SKIPPED \]", test):
            reasons[reason.strip() or "no reason given"] += 1
        # pytest, and scripts that ended with 77.
        for number in re.findall(r"^.*\b(\d+) skipped\b.* in [\d.]+s", test, flags=re.M):
            reasons[f"{name}: pytest"] += int(number)
        if re.search(r"^Test Skipped\.|SKIP_RETURN_CODE=77|Skipped$", test, flags=re.M):
            output = re.search(r"^Output:\n-+\n(.*?)\n?^<end of output>", test, flags=re.M | re.S)
            lines = [line for line in (output.group(1) if output else "").split("\n") if line.strip()]
            reasons[f"{name}: {lines[-1].strip() if lines else 'no reason given'}"] += 1
    print(f"{sum(reasons.values())} tests skipped")
    for reason, count in sorted(reasons.items()):
        print(f"  {count:3d} {reason}")


if __name__ == "__main__":
    main()
