#!/usr/bin/python3
"""Turns the sections of the wing of make_surface nose down about the line of quarter chords, in proportion to the span, the tip by
DEG degrees, as a designer may do against a stall of the tip, only far too much: twist.py DEG SURFACE OUT (OBJ)"""
import math
import sys

SPAN, ROOT, TAPER, SWEEP = 1.1963, 0.8059, 0.562, math.tan(math.radians(30))  # of make_surface wing


def turned(tip, x, y, z):
    quarter = y * SWEEP + 0.25 * ROOT * (1 + y / SPAN * (TAPER - 1))
    angle = math.radians(tip) * y / SPAN
    cosine, sine, x = math.cos(angle), math.sin(angle), x - quarter
    return quarter + cosine * x - sine * z, y, cosine * z + sine * x


def main(degrees, surface, out):
    with open(surface, encoding="utf-8") as source, open(out, "w", encoding="utf-8") as target:
        for line in source:
            words = line.split()
            if words and words[0] == "v":
                line = "v " + " ".join(map(repr, turned(float(degrees), *map(float, words[1:4])))) + "\n"
            target.write(line)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
