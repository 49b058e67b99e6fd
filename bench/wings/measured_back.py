#!/usr/bin/python3
"""Variables of wings at both limits of their ranges, measured back on the written surfaces by numpy alone.

    measured_back.py FOLDER [--program strake_measured_back] [--out DIR] [--only NAME]

FOLDER holds the surfaces of STRAKE_DATA; others are made as in kept_edges.py. strake_measured_back writes the surface of
each variable at each limit, and where the stations are at the start. Here they are cut: in streamwise planes at the same
fraction of the present semispan; with a winglet in planes of the same direction, where the foremost and the aftmost point
of the start's section have gone. Largest difference between what was asked for and what is found, and of what should
have stayed, over all variables. Ends with 1 where it is above 0.05 degrees or 0.5 %.
"""
import argparse
import math
import pathlib
import shutil
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from found_wings import read_obj  # noqa: E402
import kept_edges  # noqa: E402

ANGLES, PANELS = ("sweep", "dihedral", "twist"), ("sweep", "dihedral")
MORE = {"Cessna 210": "cessna210_flowpanel.msh"}


class Section:
    """The cut with a plane: segments, and for each of their ends the mesh edge it is on."""

    def __init__(self, points, triangles, normal, at):
        height = points @ normal - at
        below = height[triangles] < 0
        triangles = triangles[below.any(1) & ~below.all(1)]
        found, edges = [], []
        for t in triangles:
            ends = [tuple(sorted((a, b))) for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0])) if (height[a] < 0) != (height[b] < 0)]
            edges.append(ends)
            found.append([points[i] + height[i] / (height[i] - height[j]) * (points[j] - points[i]) for i, j in ends])
        self.ends, self.edges, self.height = numpy.array(found), edges, height

    def near(self, place, reach):
        keep = numpy.linalg.norm(self.ends.mean(1) - place, axis=1) < reach
        self.ends, self.edges = self.ends[keep], [e for e, k in zip(self.edges, keep) if k]


class Wing:
    def __init__(self, folder):
        self.start, self.all = read_obj(folder / "start.obj")
        lines = [line.split() for line in open(folder / "wing.txt")]
        named = {line[0]: numpy.array([float(x) for x in line[1:]]) for line in lines}
        self.span, self.downstream, self.up = named["span"], named["downstream"], named["up"]
        self.root, self.joined = named["root"][0], named["joined"][0] > 0
        self.triangles = self.all[named["triangles"].astype(int)]
        self.stations = [[float(x) for x in line[1:]] for line in lines if line[0] == "station"]
        own = numpy.unique(self.triangles)
        along = self.start[own] @ self.span
        self.tip = own[along >= along.max() - 1e-6 * (along.max() - self.root)]
        self.tip_at = along.max()
        bent = any(abs(self.frame(station)[0] @ self.span) < 0.9999 for station in self.stations)
        self.gone = [self.ties(station) if bent else None for station in self.stations]
        self.before = self.measured(self.start)

    def frame(self, station):
        up, place = numpy.array(station[2:5]), numpy.array(station[5:8])
        normal = numpy.cross(up, self.downstream)
        return normal * numpy.sign(normal @ self.span), up, place

    def ties(self, station):
        """With a winglet: the mesh edges of a section's foremost and aftmost point, and their places on them."""
        normal, _, place = self.frame(station)
        cut = Section(self.start, self.triangles, normal, place @ normal)
        cut.near(place, self.reach())
        flat = cut.ends.reshape(-1, 3) @ self.downstream
        edges = [e for pair in cut.edges for e in pair]
        chosen = [edges[flat.argmin()], edges[flat.argmax()]]
        return [(i, j, cut.height[i] / (cut.height[i] - cut.height[j])) for i, j in chosen]

    def reach(self):
        return 0.35 * (self.tip_at - self.root)

    def cut(self, points, k):
        station, tie = self.stations[k], self.gone[k]
        normal, up, place = self.frame(station)
        if tie is None:
            reach = (points[self.tip] @ self.span).mean() - self.root
            at = self.root + max(station[1], 1e-6) * reach
            cut = Section(points, self.triangles, normal, at)
        else:
            place = sum((1 - t) * points[i] + t * points[j] for i, j, t in tie) / len(tie)
            at = place @ normal
            cut = Section(points, self.triangles, normal, at)
            cut.near(place, self.reach())
        flat = numpy.stack([cut.ends @ self.downstream, cut.ends @ up], 2)
        return flat, lambda p: at * normal + p[0] * self.downstream + p[1] * up

    def measured(self, points):
        stations, axis = [], []
        for k in range(len(self.stations)):
            flat, in_space = self.cut(points, k)
            lead, trail = edges_of(flat.reshape(-1, 2))
            line = trail - lead
            chord = numpy.linalg.norm(line)
            along, across = line / chord, numpy.array([-line[1], line[0]]) / chord
            x, z = (flat - lead) @ along / chord, (flat - lead) @ across / chord
            thick, camber = shape(x, z)
            stations.append({"chord": chord, "twist": math.atan2(-line[1], line[0]), "thickness": thick, "camber": camber})
            axis.append(in_space(lead + 0.25 * line))
        panels = []
        for k in range(len(axis) - 1):
            way = axis[k + 1] - axis[k]
            out, aft, rise = way @ self.span, way @ self.downstream, way @ self.up
            stays = self.panels_upright[k] if hasattr(self, "panels_upright") else abs(rise) > abs(out)
            panels.append({"sweep": math.atan2(aft, math.hypot(out, rise) if stays else out), "dihedral": math.atan2(rise, out),
                           "upright": stays})
        self.panels_upright = [panel["upright"] for panel in panels]
        return stations, panels, (points[self.tip] @ self.span).mean() - (0 if self.joined else self.root)


def edges_of(points):
    """Those of kept_edges.py, in the direction of the chord: a blunt edge turns with the section."""
    rear = points[points[:, 0] > points[:, 0].max() - 0.03 * numpy.ptp(points[:, 0]), 1]
    trail = numpy.array([points[:, 0].max(), 0.5 * (rear.min() + rear.max())])
    lead = points[numpy.linalg.norm(points - trail, axis=1).argmax()]
    angle = math.atan2(trail[1] - lead[1], trail[0] - lead[0])
    for _ in range(4):
        turn = numpy.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        lead, trail, _ = kept_edges.edges(points @ turn)
        lead, trail = turn @ lead, turn @ trail
        angle = math.atan2(trail[1] - lead[1], trail[0] - lead[0])
    return lead, trail


def shape(x, z):
    """Largest thickness and highest point of the mean line, where segments are above each other."""
    best, highest = 0.0, 0.0
    low, high = x.min(1), x.max(1)
    for at in numpy.unique(x):
        if not 0.01 < at < 0.99:
            continue
        over = (low <= at) & (high >= at) & (high > low)
        if over.sum() < 2:
            continue
        share = (at - x[over, 0]) / (x[over, 1] - x[over, 0])
        heights = z[over, 0] + share * (z[over, 1] - z[over, 0])
        top, bottom = heights.max(), heights.min()
        best = max(best, top - bottom)
        if abs(top + bottom) / 2 > abs(highest):
            highest = (top + bottom) / 2
    return best, highest


def differences(wing, change, station, z, points):
    """What was asked for (degrees, %), then what should have stayed: chord, t/c, twist, camber, panels."""
    stations, panels, tip = wing.measured(points)
    before, panels_before, tip_before = wing.before
    asked, off = 0.0, dict.fromkeys(("chord", "thickness", "twist", "camber", "panels"), 0.0)
    if change == "span":
        asked = 100 * abs(tip / tip_before - 1 - z)
    for k, (a, b) in enumerate(zip(before, stations)):
        changes = {"chord": 100 * (b["chord"] / a["chord"] - 1), "thickness": 100 * (b["thickness"] / a["thickness"] - 1),
                   "twist": math.degrees(b["twist"] - a["twist"]), "camber": 100 * (b["camber"] - a["camber"])}
        for name, by in changes.items():
            if name == change and wing.stations[k][0] == station:
                asked = abs(by - (math.degrees(z) if name == "twist" else 100 * z))
            elif name != change:
                off[name] = max(off[name], abs(by))
    for k, (a, b) in enumerate(zip(panels_before, panels)):
        for name in PANELS:
            by = math.degrees(b[name] - a[name])
            if name == change and wing.stations[k][0] == station:
                asked = abs(by - math.degrees(z))
            else:
                off["panels"] = max(off["panels"], abs(by))
    return asked, off


def run(name, surface, options):
    folder = options.out / name.replace(" ", "_").replace(",", "")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if callable(surface):
        source = folder / "source.obj"
        surface(str(source))
    else:
        source = options.folder / surface
    done = subprocess.run([options.program, "--out", folder, source], capture_output=True,
                          text=True)
    if done.returncode != 0 or not (folder / "moved.txt").exists():
        return print(f"| {name} | {done.stderr.strip()[:200]} |", flush=True) or False
    wing = Wing(folder)
    angle = share = 0.0
    rest = dict.fromkeys(("chord", "thickness", "twist", "camber", "panels"), 0.0)
    worst = {}
    for line in open(folder / "moved.txt"):
        change, station, z, file = line.split()
        asked, off = differences(wing, change, float(station), float(z), read_obj(folder / file)[0])
        if change in ANGLES:
            angle = max(angle, asked)
        else:
            share = max(share, asked)
        for key, value in off.items():
            if value > rest[key]:
                rest[key], worst[key] = value, file[:-4]
        if not options.keep:
            (folder / file).unlink()
    print(f"| {name} | {len(wing.all)} | {angle:.3f}; {share:.2f} | {rest['chord']:.2f} | {rest['thickness']:.2f} | {rest['twist']:.3f} | "
          f"{rest['camber']:.2f} | {rest['panels']:.3f} | {', '.join(f'{k}: {v}' for k, v in worst.items()) if options.keep else ''} |", flush=True)
    return max(angle, rest["twist"], rest["panels"]) <= 0.05 and max(share, rest["chord"], rest["thickness"], rest["camber"]) <= 0.5


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default="strake_measured_back")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/measured_back"))
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", action="store_true", help="keep the surfaces, and say which variable is the worst")
    options = parser.parse_args()
    print("| wing | triangles | asked for: angles, deg; others, % | chord, % | t/c, % | twist, deg | camber, % of the chord | panels, deg | |\n"
          "|---|---|---|---|---|---|---|---|---|")
    surfaces = {name: made[0] for name, made in kept_edges.BODIES.items()} | MORE
    good = [run(name, made, options) for name, made in surfaces.items() if options.only in name]
    print(f"\n{sum(good)} of {len(good)} within 0.05 degrees and 0.5 %")
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
