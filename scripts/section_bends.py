#!/usr/bin/python3
"""Bends of plane sections through a surface before and after a run: section_bends.py START BEST OUT.svg AXIS PLACE...

START and BEST are binary STL files, AXIS is x, y or z. For each place, cuts both surfaces by the plane AXIS = PLACE, prints
how often the curvature of each section changes its sign, and draws them. The sections are resampled to 400 equal
lengths; a bend counts where the direction turns by more than a degree before it turns back, corners of more than 20
degrees are left out. Exit status 1 where a section of BEST changes more than twice as often as that of START.
"""
import math
import struct
import sys

SAMPLES = 400
BEND = math.radians(1)
CORNER = math.radians(20)


def triangles_of(path):
    with open(path, "rb") as file:
        file.seek(80)
        (count,) = struct.unpack("<I", file.read(4))
        for _ in range(count):
            numbers = struct.unpack("<12fH", file.read(50))
            yield numbers[3:6], numbers[6:9], numbers[9:12]


def loops(path, axis, place):
    """Closed and open polylines where the plane cuts, longest first."""
    u, v = [k for k in range(3) if k != axis]
    beside = {}  # point > the points it is joined to; points are the ends of edges, which triangles share bit for bit

    def crossing(a, b):
        a, b = sorted((a, b))
        s = (place - a[axis]) / (b[axis] - a[axis])
        return (a[u] + s * (b[u] - a[u]), a[v] + s * (b[v] - a[v]))

    for corners in triangles_of(path):
        above = [c[axis] >= place for c in corners]
        cut = [crossing(corners[k], corners[(k + 1) % 3]) for k in range(3) if above[k] != above[(k + 1) % 3]]
        if len(cut) == 2 and cut[0] != cut[1]:
            beside.setdefault(cut[0], []).append(cut[1])
            beside.setdefault(cut[1], []).append(cut[0])
    result = []
    while beside:
        start = next((p for p, others in beside.items() if len(others) == 1), next(iter(beside)))
        line, at = [start], start
        while beside.get(at):
            after = beside[at].pop()
            if not beside[at]:
                del beside[at]
            beside[after].remove(at)
            if not beside[after]:
                del beside[after]
            line.append(after)
            at = after
        result.append(line)
    return sorted(result, key=lambda line: -length(line))


def length(line):
    return sum(math.dist(p, q) for p, q in zip(line, line[1:]))


def resampled(line, count):
    step, left, points = length(line) / count, 0.0, []
    for p, q in zip(line, line[1:]):
        side = math.dist(p, q)
        while left < side:
            points.append(tuple(a + left / side * (b - a) for a, b in zip(p, q)))
            left += step
        left -= side
    return points


def sign_changes(line):
    """Of the curvature, and the turns they are counted from."""
    points = resampled(line, SAMPLES)
    is_closed = line[0] == line[-1]
    ends = range(len(points)) if is_closed else range(1, len(points) - 1)
    runs = []  # how far the direction turns before it turns back
    for k in ends:
        p, q, r = points[k - 1], points[k], points[(k + 1) % len(points)]
        turn = math.atan2(r[1] - q[1], r[0] - q[0]) - math.atan2(q[1] - p[1], q[0] - p[0])
        turn = math.remainder(turn, 2 * math.pi)
        if abs(turn) > CORNER:
            continue
        if runs and runs[-1] * turn >= 0:
            runs[-1] += turn
        else:
            runs.append(turn)
    while len(runs) > 1 and min(map(abs, runs)) < BEND:  # noise: the runs beside it are one
        k = min(range(len(runs)), key=lambda i: abs(runs[i]))
        low, high = max(k - 1, 0), min(k + 2, len(runs))
        runs[low:high] = [sum(runs[low:high])]
    changes = sum(a * b < 0 for a, b in zip(runs, runs[1:]))
    return changes + (is_closed and len(runs) > 1 and runs[0] * runs[-1] < 0)


def main(start, best, out, axis, places):
    axis = "xyz".index(axis)
    width, height, margin = 900, 260, 40
    rows, worse = [], 0
    for row, place in enumerate(places):
        lines = [loops(path, axis, place) for path in (start, best)]
        if not all(lines):
            sys.exit(f"no section at {'xyz'[axis]} = {place:g}")
        counts = [sum(sign_changes(line) for line in found) for found in lines]
        worse += counts[1] > 2 * max(counts[0], 1)
        print(f"{'xyz'[axis]} = {place:g}: {counts[0]} sign changes of the curvature at the start, {counts[1]} at the end")
        every = [p for found in lines for line in found for p in line]
        low = [min(p[k] for p in every) for k in (0, 1)]
        high = [max(p[k] for p in every) for k in (0, 1)]
        scale = min((width - 2 * margin) / (high[0] - low[0]), (height - 2 * margin) / (high[1] - low[1]))
        for found, colour in zip(lines, ("#999", "#1f5fa8")):
            for line in found:
                path = " ".join(f"{margin + (p[0] - low[0]) * scale:.1f},{(row + 1) * height - margin - (p[1] - low[1]) * scale:.1f}"
                                for p in resampled(line, SAMPLES) + [line[-1]])
                rows.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        rows.append(f'<text x="{margin}" y="{row * height + 25}">{"xyz"[axis]} = {place:g}: {counts[0]} changes of sign at the '
                    f"start (grey), {counts[1]} at the end (blue)</text>")
    size = height * len(places)
    with open(out, "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {size}" font-family="sans-serif" font-size="15">\n'
                   f'<rect width="{width}" height="{size}" fill="white"/>\n' + "\n".join(rows) + "\n</svg>\n")
    return 1 if worse else 0


if __name__ == "__main__":
    if len(sys.argv) < 6 or sys.argv[4] not in ("x", "y", "z"):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:5], [float(place) for place in sys.argv[5:]]))
