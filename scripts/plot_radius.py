#!/usr/bin/env python3
"""Draws the radii of a body of revolution before and after a run against the Sears-Haack body of the same volume:
plot_radius.py START.obj BEST.obj OUT.svg

Dots are every third vertex (x, sqrt(y^2 + z^2)); radii are drawn ten times as large as lengths. Prints the largest and the root
mean square distance of BEST's radii from the closed form, over the largest radius.
"""
import math
import sys


def read(path):
    vertices, triangles = [], []
    with open(path) as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append(tuple(map(float, words[1:4])))
            elif words[:1] == ["f"]:
                triangles.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return vertices, triangles


def volume(vertices, triangles):
    total = 0.0
    for a, b, c in triangles:
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = vertices[a], vertices[b], vertices[c]
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return abs(total) / 6


def main(start, best, out):
    before, _ = read(start)
    after, triangles = read(best)
    begin, end = min(v[0] for v in after), max(v[0] for v in after)
    length = end - begin
    largest = math.sqrt(16 * volume(after, triangles) / (3 * math.pi ** 2 * length))

    def wanted(x):
        k = min(1.0, max(0.0, (x - begin) / length))
        return largest * (4 * k * (1 - k)) ** 0.75

    off = [math.hypot(y, z) - wanted(x) for x, y, z in after]
    print(f"largest {max(map(abs, off)) / largest:.2e}, rms {math.sqrt(sum(d * d for d in off) / len(off)) / largest:.2e}")

    width, height, margin = 900, 620, 50
    scale = (width - 2 * margin) / length

    def place(x, r):
        return f"{margin + (x - begin) * scale:.1f}", f"{height - margin - 10 * r * scale:.1f}"

    def dots(vertices, colour):
        path = "".join("M{},{}h0".format(*place(x, math.hypot(y, z))) for x, y, z in vertices[::3])
        return f'<path d="{path}" stroke="{colour}" stroke-width="3" stroke-linecap="round"/>'

    line = " ".join(",".join(place(begin + length * i / 400, wanted(begin + length * i / 400))) for i in range(401))
    words = [("#999", "start"), ("#1f5fa8", "after the run"), ("#c03020", "Sears-Haack body of the same volume (line)")]
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="15">',
           f'<rect width="{width}" height="{height}" fill="white"/>', dots(before, "#bbb"), dots(after, "#1f5fa8"),
           f'<polyline points="{line}" fill="none" stroke="#c03020" stroke-width="1.5"/>']
    for row, (colour, text) in enumerate(words):
        svg.append(f'<text x="{margin}" y="{30 + 20 * row}" fill="{colour}">{text}</text>')
    svg.append(f'<text x="{margin}" y="{height - 15}">x from {begin:g} to {end:g}; radius x 10</text></svg>')
    with open(out, "w") as file:
        file.write("\n".join(svg) + "\n")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
