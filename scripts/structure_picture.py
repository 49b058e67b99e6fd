#!/usr/bin/env python3
"""Draws which folder includes which, from the #include lines of the sources: structure_picture.py [--check]

Writes docs/pictures/structure.svg: one floor for each top folder, one room for each folder in it, an arrow from a room to
each room that it includes from. Arrows that follow from others are left out. A floor may include from every floor below
it. Includes that close a circle of folders are drawn in red and printed; exit status 1 then. With --check nothing is
written, and the exit status is also 1 if the picture in docs/ is out of date.
"""
import collections
import pathlib
import re
import sys
from xml.sax.saxutils import escape

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/pictures/structure.svg"
FLOORS = ["core", "objectives", "optimize", "casefile", "cases", "viewer", "report", "studio", "bench", "python", "cli"]
ROOF = {"cli": "the program", "python": "the module", "bench": "benchmarks",
        "cases": "examples and their surfaces"}  # nobody below includes from these; drawn in one row
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)
INK, FAINT, WRONG, ROOM, FLOOR = "#22303c", "#5d7183", "#c62828", "#ffffff", "#e8eef3"
LEFT, GAP, BOX_HEIGHT, WIDTH = 150, 16, 40, 1110


def read_sources():
    """Units of each folder, and the includes between folders: {(from, to): [(file, file)]}."""
    files = [p.relative_to(ROOT).as_posix() for top in FLOORS for p in sorted((ROOT / top).rglob("*.[ch]pp"))]
    known, units, includes = set(files), collections.defaultdict(set), collections.defaultdict(list)
    for file in files:
        folder = file.rpartition("/")[0]
        units[folder].add(file.rpartition(".")[0])
        for target in INCLUDE.findall((ROOT / file).read_text(encoding="utf-8", errors="replace")):
            if target in known and target.rpartition("/")[0] != folder:
                includes[folder, target.rpartition("/")[0]].append((file, target))
    return units, includes


def reach(edges, start):
    """All that is reached from `start`, by one edge or more."""
    found, front = set(), [start]
    while front:
        for target in sorted(edges.get(front.pop(), ())):
            if target not in found:
                found.add(target)
                front.append(target)
    return found


def ordered(rooms, edges):
    """Rooms so that each comes after those that it includes from; by name where that leaves a choice."""
    depth = {}

    def look(room, above):
        if room not in depth:
            depth[room] = 1 + max((look(t, above | {room}) for t in edges.get(room, ()) if t not in above), default=0)
        return depth[room]

    for room in sorted(rooms):
        look(room, {room})
    return sorted(rooms, key=lambda room: (depth[room], room))


def child_edges(parent, includes):
    """Edges between the folders directly inside of `parent` ("" for the top)."""
    edges, prefix = collections.defaultdict(set), parent + "/" if parent else ""
    for one, other in includes:
        if one.startswith(prefix) and other.startswith(prefix):
            a, b = one[len(prefix):].split("/")[0], other[len(prefix):].split("/")[0]
            if a and b and a != b:
                edges[a].add(b)
    return edges


def circles(parent, edges):
    return [f"{parent or 'top'}: {a} and {b} include each other, directly or through others"
            for a in sorted(edges) for b in sorted(edges[a]) if a in reach(edges, b)]


def box(x, y, width, name, note, color=INK):
    return (f'<rect x="{x:.0f}" y="{y}" width="{width:.0f}" height="{BOX_HEIGHT}" rx="4" fill="{ROOM}" stroke="{FAINT}"/>'
            f'<text x="{x + width / 2:.0f}" y="{y + 17}" text-anchor="middle" fill="{color}">{escape(name)}</text>'
            f'<text x="{x + width / 2:.0f}" y="{y + 32}" text-anchor="middle" font-size="10" fill="{FAINT}">{escape(note)}</text>')


def floor(top, y, units, includes):
    """SVG of one floor and its height."""
    edges = child_edges(top, includes)
    rooms = sorted({f[len(top) + 1:].split("/")[0] for f in units if f.startswith(top + "/")})
    out, place, x, deepest = [], {}, LEFT, 0
    for room in ordered(rooms, edges):
        folder = f"{top}/{room}"
        inner = ordered({f[len(folder) + 1:].split("/")[0] for f in units if f.startswith(folder + "/")},
                        child_edges(folder, includes))
        count = sum(len(u) for f, u in units.items() if f == folder or f.startswith(folder + "/"))
        note = ", ".join(inner) if inner else f"{count} units"
        width = max(8.2 * len(room), 5.4 * len(note)) + 16
        place[room] = (x, width)
        out.append(box(x, y + 14, width, room, note))
        x += width + GAP
    for one in place:
        for other in sorted(edges.get(one, ())):
            back = one in reach(edges, other)
            if not back and any(other in reach(edges, middle) for middle in edges[one] - {other}):
                continue  # follows from others
            (xa, wa), (xb, wb) = place[one], place[other]
            a, b = xa + wa * 0.35, xb + wb * 0.65
            depth = 10 + 0.075 * abs(a - b)
            deepest = max(deepest, depth)
            bottom = y + 14 + BOX_HEIGHT
            out.append(f'<path d="M{a:.0f},{bottom} C{a:.0f},{bottom + depth * 1.35:.0f} {b:.0f},{bottom + depth * 1.35:.0f} '
                       f'{b:.0f},{bottom + 3}" fill="none" stroke="{WRONG if back else INK}" marker-end="url(#{"wrong" if back else "tip"})"/>')
    height = 14 + BOX_HEIGHT + (deepest + 12 if deepest else 14)
    total = sum(len(u) for f, u in units.items() if f == top or f.startswith(top + "/"))
    head = (f'<rect x="4" y="{y}" width="{WIDTH - 8}" height="{height:.0f}" rx="6" fill="{FLOOR}"/>'
            f'<text x="16" y="{y + 30}" font-weight="bold" fill="{INK}">{top}/</text>'
            f'<text x="16" y="{y + 45}" font-size="10" fill="{FAINT}">{total} units</text>')
    return head + "\n".join(out), int(height)


def roof(y, there, units):
    """SVG of the row that nothing else stands on, and its height."""
    out, x = [f'<rect x="4" y="{y}" width="{WIDTH - 8}" height="{BOX_HEIGHT + 28}" rx="6" fill="{FLOOR}"/>'], LEFT
    for top in (t for t in ROOF if t in there):
        count = sum(len(u) for f, u in units.items() if f == top or f.startswith(top + "/"))
        note = f"{ROOF[top]}, {count} units"
        width = max(8.2 * len(top), 5.4 * len(note)) + 16
        out.append(box(x, y + 14, width, top + "/", note))
        x += width + GAP
    return "\n".join(out), BOX_HEIGHT + 28


def draw(units, includes):
    there = [f for f in FLOORS if any(u == f or u.startswith(f + "/") for u in units)]
    parents = ["", *sorted({"/".join(u.split("/")[:n]) for u in units for n in range(1, u.count("/") + 2)})]
    wrong = [w for parent in parents for w in circles(parent, child_edges(parent, includes))]
    top_edges = child_edges("", includes)
    wrong += [f"top: {a} includes from {b}, which stands above it" for a in sorted(top_edges) for b in sorted(top_edges[a])
              if there.index(b) > there.index(a)]
    parts = [f'<text x="16" y="20" fill="{FAINT}">A floor includes only from floors below it. An arrow leads from a '
             'room to a room that it includes from; arrows that follow from others are left out.</text>']
    svg, height = roof(30, there, units)
    parts.append(svg)
    y = 40 + height
    for top in (t for t in reversed(there) if t not in ROOF):
        svg, height = floor(top, y, units, includes)
        parts.append(svg)
        y += height + 10
    markers = "".join(f'<marker id="{name}" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="7" markerHeight="7" '
                      f'orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="{color}"/></marker>'
                      for name, color in (("tip", INK), ("wrong", WRONG)))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y}" width="{WIDTH}" height="{y}" '
            f'font-family="sans-serif" font-size="13">\n<defs>{markers}</defs>\n'
            f'<rect width="{WIDTH}" height="{y}" fill="#ffffff"/>\n' + "\n".join(parts) + "\n</svg>\n"), wrong


def main():
    units, includes = read_sources()
    svg, wrong = draw(units, includes)
    print(*wrong, sep="\n", end="\n" if wrong else "")
    if sys.argv[1:] == ["--check"]:
        old = not PICTURE.is_file() or PICTURE.read_text(encoding="utf-8") != svg
        if old:
            print(f"{PICTURE.relative_to(ROOT)} is out of date: run scripts/structure_picture.py")
        sys.exit(1 if wrong or old else 0)
    PICTURE.write_text(svg, encoding="utf-8")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
