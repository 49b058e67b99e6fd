#!/usr/bin/python3
"""Wings that `strake info --planform` finds on the real surfaces, against sections by a program of its own.

    found_wings.py FOLDER [--strake PROGRAM] [--only NAME]

FOLDER holds the surfaces of STRAKE_DATA. Axes and the root are stated here by hand, from pictures: everything else
(span, exposed area, sweep of the quarter chord) is measured from the triangles by numpy alone. Prints a table and ends
with 1 where fewer than nine of ten wings agree within 1 %, or where a body that has none shows one.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

# name: (span, downstream, root, largest coordinates downstream and up that still
# are the wing's).
WINGS = {
    "bwb_machline_medium.vtk": ("+y", "-x", 0, None, None),
    "cessna210_flowpanel.msh": ("+y", "+x", 1.932, 15, None),
    "citationX_raw.ply": ("+z", "+x", 0.905, 7, -0.6),
    "dpw_w1_pypan.tri": ("-y", "+x", 0, None, None),
    "hsct_pypan.tri": ("+y", "+x", 0.0355, 1.2, 0),
    "oneraM6_pyhyp_small.ply": ("+z", "+x", 0, None, None),
    "oneraM6_pyhyp_small_full.ply": ("+z", "+x", 0, None, None),
    "oneraM6_su2_surface.stl": ("+y", "+x", 0, None, None),
    "supersonic_wing_body_pypan.stl": ("+y", "-x", 0, None, None),
    "three_element_wing_cpanel.tri": ("+y", "+x", 0, 0.99, None),
    "wing717_pyhyp.ply": ("+z", "+x", 0, None, None),
    "wing_c172_pygeo.stl": ("+z", "+x", 0, None, None),
    "zeroebwb_93k.ply": ("+x", "-z", 0, None, None),
}
# All-moving plates of constant thickness, aspect ratio below 1: neither a wing that must be found nor a body without.
NOT_COUNTED = {"x43_parts.ply"}
# Stated where the shape comes from: span, area, sweep in degrees. DPW-W1: AIAA drag prediction workshop 3. ONERA M6:
# AGARD AR-138 B1, without the rounded tip that the files have beyond it. Cessna 172: the script that lofted it, up to
# its rounded tip. Three elements: chord 1, span 3.
STATED = {
    "dpw_w1_pypan.tri": (1.524, 0.290322, 15),
    "oneraM6_su2_surface.stl": (2.3926, 1.5064, 26.7),
    "oneraM6_pyhyp_small.ply": (2.3926, 1.5064, 26.7),
    "wing_c172_pygeo.stl": (10.58, 16.3015, None),
    "three_element_wing_cpanel.tri": (3, 3, 0),
}


def unit(word):
    way = numpy.zeros(3)
    way["xyz".index(word[1])] = -1 if word[0] == "-" else 1
    return way


def read_obj(path):
    points, triangles = [], []
    for line in open(path):
        if line.startswith("v "):
            points.append([float(x) for x in line.split()[1:4]])
        elif line.startswith("f "):
            triangles.append([int(x.split("/")[0]) - 1 for x in line.split()[1:4]])
    return numpy.array(points), numpy.array(triangles)


def pieces(points, triangles, normal, at):
    """The cut with a plane: arrays of points, one for each connected piece."""
    height = points @ normal - at
    of = height[triangles]
    crossing = numpy.where((of.min(1) < 0) & (of.max(1) >= 0))[0]
    owner, cut, edges = {}, [], {}

    def root(i):
        while owner[i] != i:
            i = owner[i]
        return i

    for t in crossing:
        for a, b in ((0, 1), (1, 2), (2, 0)):
            i, j = sorted((triangles[t][a], triangles[t][b]))
            if (height[i] < 0) == (height[j] < 0):
                continue
            if (i, j) not in edges:
                edges[i, j] = len(cut)
                owner[len(cut)] = len(cut)
                cut.append(points[i] + height[i] / (height[i] - height[j]) * (points[j] - points[i]))
        used = [edges[e] for e in (tuple(sorted((triangles[t][a], triangles[t][b]))) for a, b in ((0, 1), (1, 2), (2, 0)))
                if e in edges and (height[e[0]] < 0) != (height[e[1]] < 0)]
        owner[root(used[0])] = root(used[1])
    groups = {}
    for i in owner:
        groups.setdefault(root(i), []).append(cut[i])
    return [numpy.array(group) for group in groups.values()]


def airfoil(groups, downstream, up, limits):
    """The points of the longest piece and of slats and flaps: pieces before and behind it."""
    for way, limit in zip((downstream, up), limits):
        groups = [g for g in groups if limit is None or (g @ way).max() <= limit]
    if not groups:
        return None
    low, high = (lambda g: (g @ downstream).min()), (lambda g: (g @ downstream).max())
    groups.sort(key=lambda g: high(g) - low(g), reverse=True)
    chosen = groups[:1]
    for group in groups[1:]:
        all_x = numpy.concatenate(chosen) @ downstream
        size, own = all_x.max() - all_x.min(), high(group) - low(group)
        shared = min(high(group), all_x.max()) - max(low(group), all_x.min())
        height = abs((group @ up).mean() - (numpy.concatenate(chosen) @ up).mean())
        if own > 0.05 * size and -0.05 * size < shared < 0.7 * own and height < 0.15 * size:
            chosen.append(group)
    return numpy.concatenate(chosen)


def measured(points, triangles, span, downstream, root, limits, count=160):
    up = numpy.cross(downstream, span)
    if up.sum() < 0:
        up = -up
    tip = (points @ span).max()
    width = (tip - root) / count
    chords, quarters, places = [], [], []
    for k in range(count):
        place = root + (k + 0.5) * width
        section = airfoil(pieces(points, triangles, span, place), downstream, up, limits)
        if section is None or len(section) < 3:
            continue
        flat = numpy.stack([section @ downstream, section @ up], 1)
        trailing = flat[flat[:, 0].argmax()]
        away = numpy.linalg.norm(flat - trailing, axis=1)
        leading = flat[away.argmax()]
        chords.append(away.max())
        quarters.append((leading + 0.25 * (trailing - leading))[0])
        places.append(place)
    chords, places = numpy.array(chords), numpy.array(places)
    within = places < root + 0.97 * (tip - root)  # tips are rounded
    slope = numpy.polyfit(places[within], numpy.array(quarters)[within], 1)[0]
    return 2 * tip, 2 * chords.sum() * width, numpy.degrees(numpy.arctan(slope))


def shown(program, path):
    answer = subprocess.run([program, "info", "--planform", "--json", path], capture_output=True, text=True, timeout=300)
    if answer.returncode != 0:
        sys.exit(f"found_wings.py: {path}: {answer.stderr.strip()}")
    wing = json.loads(answer.stdout).get("planform")
    return wing and (wing["span"], wing["area"], numpy.degrees(wing["sweep"]))


def within(found, wanted):
    """Span and area to 1 %, sweep to 1 % of it, but not less than 0.3 degrees."""
    return (abs(found[0] / wanted[0] - 1) <= 0.01 and abs(found[1] / wanted[1] - 1) <= 0.01
            and (wanted[2] is None or abs(found[2] - wanted[2]) <= max(0.3, 0.01 * abs(wanted[2]))))


def words(values):
    return " | ".join("" if v is None else f"{v:.6g}" if i < 2 else f"{v:.2f}" for i, v in enumerate(values))


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("folder", type=pathlib.Path)
    options.add_argument("--strake", default="strake")
    options.add_argument("--only")
    asked = options.parse_args()
    good, wings, wrong = 0, 0, []
    print("| surface | span | area | sweep, deg | span by numpy | area | sweep | agree | stated span | area | sweep |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|")
    for path in sorted(asked.folder.iterdir()):
        if path.suffix == ".md" or (asked.only and asked.only not in path.name):
            continue
        found = shown(asked.strake, path)
        if path.name not in WINGS:
            if found and path.name not in NOT_COUNTED:
                wrong.append(path.name)
            continue
        wings += 1
        span, downstream, root, *limits = WINGS[path.name]
        with tempfile.TemporaryDirectory() as folder:
            plain = folder + "/surface.obj"
            subprocess.run([asked.strake, "repair", "--isolated", "-q", "-o", plain, path], check=True, capture_output=True)
            wanted = measured(*read_obj(plain), unit(span), unit(downstream), root, limits)
        agree = found is not None and within(found, wanted)
        good += agree
        print(f"| {path.name} | {words(found or (None,) * 3)} | {words(wanted)} | {'yes' if agree else 'no'} | "
              f"{words(STATED.get(path.name, (None,) * 3))} |", flush=True)
    print(f"\n{good} of {wings} wings agree; wings on bodies without: {', '.join(wrong) or 'none'}")
    return 0 if good >= 0.9 * wings and not wrong else 1


if __name__ == "__main__":
    sys.exit(main())
