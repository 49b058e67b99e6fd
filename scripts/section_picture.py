#!/usr/bin/python3
"""Sections of a wing along y, several surfaces over one another: section_picture.py OUT.svg --at 0.3,0.8,1.2 NAME=SURFACE.obj ...

Each section is drawn over its chord, heights three times as large as lengths. Coordinates are those of the file. At most four surfaces.
"""
import argparse
import html
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cases/published"))
from obj import read_obj  # noqa: E402

COLORS = ["#888888", "#0b62a8", "#c5501f", "#2f8f4e"]
ACROSS, GAP, HEIGHT_SCALE = 300, 24, 3.0


def named_surface(word):
    name, _, path = word.rpartition("=")
    if not name or not path:
        raise argparse.ArgumentTypeError(f"'{word}' needs a name and a file with '=' between")
    return name, path


def places(words):
    return [float(y) for y in words.split(",")]


def segments(surface, y):
    """n x 2 x (x, z): where triangles meet the plane; none: it misses the surface."""
    vertices, triangles = surface
    corners = vertices[triangles]
    above = corners[:, :, 1] > y
    found = []
    for corner, side in zip(corners[above.any(1) & ~above.all(1)], above[above.any(1) & ~above.all(1)]):
        ends = []
        for i, j in ((0, 1), (1, 2), (2, 0)):
            if side[i] != side[j]:
                t = (y - corner[i, 1]) / (corner[j, 1] - corner[i, 1])
                ends.append((corner[i] + t * (corner[j] - corner[i]))[[0, 2]])
        found.append(ends)
    return np.array(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--at", required=True, type=places, metavar="Y,...", help="places along y")
    parser.add_argument("surfaces", nargs="+", type=named_surface, metavar="NAME=SURFACE.obj", help=f"at most {len(COLORS)}")
    options = parser.parse_args()
    if len(options.surfaces) > len(COLORS):
        parser.error(f"{len(options.surfaces)} surfaces; at most {len(COLORS)}, one color each")
    names, paths = zip(*options.surfaces)
    surfaces = [read_obj(path) for path in paths]
    lines, down = [], 10 + 18
    for y in options.at:
        cuts = [segments(surface, y) for surface in surfaces]
        for path, (vertices, _), cut in zip(paths, surfaces, cuts):
            if len(cut) == 0:
                low, high = vertices[:, 1].min(), vertices[:, 1].max()
                sys.exit(f"section_picture.py: {path}: no section at y = {y:g}; the surface extends from y = {low:g} to {high:g}")
        front, back = cuts[0][..., 0].min(), cuts[0][..., 0].max()
        middle, scale = np.mean(cuts[0][..., 1]), ACROSS / (back - front)
        heights = [HEIGHT_SCALE * scale * (cut[..., 1] - middle) for cut in cuts]
        top, bottom = max(h.max() for h in heights), min(h.min() for h in heights)
        lines.append(f'<text x="6" y="{down + 10:.0f}">y = {y:g}</text>')
        zero = down + 16 + top
        for color, cut, height in zip(COLORS, cuts, heights):
            x = 60 + scale * (cut[..., 0] - front)
            path = "".join(f"M{x[k, 0]:.1f} {zero - height[k, 0]:.1f}L{x[k, 1]:.1f} {zero - height[k, 1]:.1f}" for k in range(len(x)))
            lines.append(f'<path d="{path}" stroke="{color}" fill="none" stroke-width="1.2"/>')
        down = zero - bottom + GAP
    legend = "".join(f'<text x="{60 + 110 * k}" y="16" fill="{color}">{html.escape(name)}</text>' for k, (name, color) in enumerate(zip(names, COLORS)))
    options.out.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {60 + ACROSS + 70} {down:.0f}" font-family="sans-serif" '
                           f'font-size="11"><rect width="100%" height="100%" fill="white"/>{legend}\n' + "\n".join(lines) + "\n</svg>\n", encoding="utf-8")


if __name__ == "__main__":
    main()
