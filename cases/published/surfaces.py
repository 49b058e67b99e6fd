#!/usr/bin/env python3
"""Start surfaces of the published problems: surfaces.py KIND -o FILE.obj [--triangles N]

Plain Python, so that the surfaces can be made wherever Strake runs. Every body of revolution has its axis along x and its vertices
on rings, which `invariance: {revolve: x}` needs.
"""
import argparse
import math


class Surface:
    """Vertices and triangles, both of which only grow."""

    def __init__(self):
        self.vertices, self.triangles = [], []
        self.groups = []  # (name, number of triangles before it)

    def ring(self, x, r, around):
        """Indices of a ring's vertices; one vertex where the radius is 0."""
        count = around if r > 0 else 1
        first = len(self.vertices)
        for k in range(count):
            phi = 2 * math.pi * k / around
            self.vertices.append((x, r * math.cos(phi), r * math.sin(phi)))
        return list(range(first, first + count))

    def strip(self, a, b):
        """Triangles between ring a and ring b behind it, outward. Diagonals alternate, so that none winds around the body."""
        n = max(len(a), len(b))
        for k in range(n):
            m = (k + 1) % n
            if len(a) == 1:
                self.triangles.append((a[0], b[m], b[k]))
            elif len(b) == 1:
                self.triangles.append((a[k], a[m], b[0]))
            elif k % 2:
                self.triangles += [(a[k], a[m], b[k]), (a[m], b[m], b[k])]
            else:
                self.triangles += [(a[k], a[m], b[m]), (a[k], b[m], b[k])]

    def write(self, path):
        with open(path, "w", encoding="ascii") as out:
            for v in self.vertices:
                out.write("v %.17g %.17g %.17g\n" % v)
            for k, t in enumerate(self.triangles):
                for name, first in self.groups:
                    if first == k:
                        out.write(f"g {name}\n")
                out.write("f %d %d %d\n" % tuple(i + 1 for i in t))


def body_of_revolution(points, around):
    """A closed body through the rings (x, r), nose first; rings of radius 0 are its ends.

    All sections are polygons of the same kind: rings turned against each other would make the areas swing between them.
    """
    surface, before = Surface(), None
    for x, r in points:
        ring = surface.ring(x, r, around)
        if before is not None:
            surface.strip(before, ring)
        before = ring
    return surface


def places(count):
    """count + 1 places in [0, 1], equidistant on a half circle: fine where areas of least drag grow with the power 3/2 (at points
    and before a base). With rings further apart there the facets alone cost drag: 0.36 % of it with 208 rings twice as far apart.
    """
    return [(1 - math.cos(math.pi * k / count)) / 2 for k in range(count + 1)]


LENGTH, RADIUS = 1.0, 0.05  # of the bodies for wave drag


def cylinder_with_cones(k):
    return RADIUS * min(1, k / 0.25, (1 - k) / 0.25)


def bumped_spindle(k):
    """Radius by the power 3/4 of a parabola, and the area larger and smaller by up to 30 % five times."""
    return RADIUS * (4 * k * (1 - k)) ** 0.75 * math.sqrt(1 + 0.3 * math.sin(5 * math.pi * k) * math.sin(math.pi * k))


def cone_and_cylinder(k):
    return RADIUS * min(1, k / 0.5)


def bumped_ogive(k):
    """The same up to its largest radius, with three bumps."""
    return RADIUS * (k * (2 - k)) ** 0.75 * math.sqrt(1 + 0.3 * math.sin(3 * math.pi * k) * math.sin(math.pi * k))


def slender(profile, triangles, base=False):
    # Triangles twice as long as wide: the sections, not the circles, are what counts.
    around = max(12, 2 * round(math.sqrt(triangles / 400)))
    count = max(20, round(triangles / (2 * around)))
    points = [(LENGTH * k, profile(k)) for k in places(count)]
    points[0] = (0.0, 0.0)
    if base:
        radius = points[-1][1]
        disc = max(2, round(radius / (2 * math.pi * radius / around) / 2))
        points += [(LENGTH, radius * (1 - j / disc)) for j in range(1, disc)] + [(LENGTH, 0.0)]
    else:
        points[-1] = (LENGTH, 0.0)
    return body_of_revolution(points, around)


def nose(exponent, triangles):
    """A body of length 3 and base diameter 1 whose radius grows with this power of x; its polygons have the areas of circles. Rings are
    finer at the tip.
    """
    around = max(12, 2 * round(math.sqrt(triangles / 300)))
    radius = 0.5 * math.sqrt(2 * math.pi / (around * math.sin(2 * math.pi / around)))
    disc = max(2, round(around / (2 * math.pi)))
    count = max(12, round(triangles / (2 * around)) - disc)
    points = [(3 * (k / count) ** 1.7, radius * (k / count) ** (1.7 * exponent)) for k in range(count + 1)]
    points += [(3.0, radius * (1 - j / disc)) for j in range(1, disc)] + [(3.0, 0.0)]
    return body_of_revolution(points, around)


def frustum(height, triangles):
    """A cone cut at 0.3 of the radius: flat nose at x = -height, base at x = 0, whose polygon has the area of the unit circle. Rings
    are finer at the nose, where a body of least resistance is round.
    """
    around = 4 * round(math.sqrt(triangles / 6) / 2)
    radius = math.sqrt(2 * math.pi / (around * math.sin(2 * math.pi / around)))
    flat = max(2, round(triangles / (2 * around) / 12))
    side = max(8, round(triangles / (2 * around)) - 2 * flat)
    points = [(-height, 0.3 * radius * j / flat) for j in range(flat)]
    for k in range(side + 1):
        s = (k / side) ** 1.5
        points.append((height * (s - 1), radius * (0.3 + 0.7 * s)))
    points += [(0.0, radius * (1 - j / flat)) for j in range(1, flat)] + [(0.0, 0.0)]
    return body_of_revolution(points, around)


def rectangular_wing(span, triangles, raised=0.0):
    """The right half of a rectangular wing of chord 1, NACA 0012 with a sharp trailing edge, open at y = 0, with a flat tip. One whose
    tip is raised along a parabola is half as thick, and open at the tip, too: lids of a sharp edge fold first when the wing is bent up.
    """
    chordwise = max(6, round(math.sqrt(triangles / 6)))
    spanwise = max(6, round(triangles / (4 * chordwise)))
    surface = Surface()

    def height(x):
        return (0.3 if raised else 0.6) * (0.2969 * math.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)

    rows = []
    for s in range(spanwise + 1):  # finer to the tip, where the load falls
        y = span / 2 * math.sin(math.pi / 2 * s / spanwise)
        row = []
        for k in range(2 * chordwise):  # from the trailing edge over the upper side forward, and back below
            t = math.pi * k / chordwise
            x = (1 + math.cos(t)) / 2
            row.append(len(surface.vertices))
            z = 0.0 if k % chordwise == 0 else height(x) * (1 if k < chordwise else -1)
            surface.vertices.append((x, y, z + raised * (2 * y / span) ** 2))
        rows.append(row)
    for a, b in zip(rows, rows[1:]):
        surface.strip(b, a)
    tip = rows[-1]
    for k in range(0 if raised else chordwise):
        upper, lower = tip[k:k + 2], [tip[-k], tip[-k - 1]]
        if k > 0:
            surface.triangles.append((upper[0], lower[0], upper[1]))
        if k < chordwise - 1:
            surface.triangles.append((upper[1], lower[0], lower[1]))
    return surface


# Half thickness of the ONERA D section over the chord, sqrt(x) (1 - x) times a polynomial of Bernstein's: fitted here to sections of the wing
# as meshes of others have it, 0.0008 of the chord off at most, sharp at its end.
ONERA_D = (0.17776, 0.01745, 0.26943, -0.01635, 0.25493, 0.05268, 0.17269)


def onera_d(x):
    n = len(ONERA_D) - 1
    return x ** 0.5 * (1 - x) * sum(b * math.comb(n, k) * x**k * (1 - x) ** (n - k) for k, b in enumerate(ONERA_D))


def onera_m6(triangles):
    """The right half of the ONERA M6 wing (AGARD AR-138, B1): root chord 0.8059, semispan 1.1963, taper 0.562, leading edge swept by 30 degrees,
    open at y = 0. The tip is half a body of revolution about its chord.
    """
    chordwise = max(8, 2 * round(math.sqrt(triangles / 14)))
    around_tip = max(2, round(chordwise / 12))
    spanwise = max(8, round(triangles / (4 * chordwise)) - around_tip)
    places = [(t + 0.2 * math.sin(math.pi * t) / math.pi, 0.0) for t in (s / spanwise for s in range(spanwise + 1))]
    places += [(1.0, math.pi / 2 * k / around_tip) for k in range(1, around_tip + 1)]
    surface, rows, number = Surface(), [], {}
    for share, turn in places:
        chord, row = 0.8059 * (1 - 0.438 * share), []
        for k in range(2 * chordwise):  # from the trailing edge over the upper side forward, and back below
            x = (1 + math.cos(math.pi * min(k, 2 * chordwise - k) / chordwise)) / 2  # the same on both sides, which meet at the tip
            thick = 0.0 if k % chordwise == 0 else chord * onera_d(x)
            side = 1 if k < chordwise else -1
            z = 0.0 if turn == math.pi / 2 else side * thick * math.cos(turn)
            point = (1.1963 * share * math.tan(math.radians(30)) + chord * x, 1.1963 * share + thick * math.sin(turn), z)
            if point not in number:
                number[point] = len(surface.vertices)
                surface.vertices.append(point)
            row.append(number[point])
        rows.append(row)
    for a, b in zip(rows, rows[1:]):
        surface.strip(b, a)
    surface.triangles = [t for t in surface.triangles if len(set(t)) == 3]
    return surface


def wing_panels(triangles):
    """Two swept panels beside a body along x of length 1, each closed: biconvex sections 6 % thick."""
    chordwise = max(6, 2 * round(math.sqrt(triangles / 48)))
    spanwise = max(4, round(triangles / (8 * chordwise)))
    surface = Surface()
    for side in (1, -1):
        rows = []
        for s in range(spanwise + 1):
            k = s / spanwise
            y, front, chord = 0.07 + 0.18 * k, 0.30 + 0.22 * k, 0.30 - 0.18 * k
            row = []
            for j in range(2 * chordwise):
                x = (1 + math.cos(math.pi * j / chordwise)) / 2
                z = 0.12 * x * (1 - x) * (1 if 0 < j < chordwise else -1 if j > chordwise else 0)
                row.append(len(surface.vertices))
                surface.vertices.append((front + chord * x, side * y, chord * z))
            rows.append(row if side > 0 else [row[0]] + row[:0:-1])
        for a, b in zip(rows, rows[1:]):
            surface.strip(b, a)
        for row, at_tip in ((rows[0], False), (rows[-1], True)):
            for j in range(chordwise):
                upper, lower = row[j:j + 2], [row[-j], row[-j - 1]]
                lid = [(upper[0], lower[0], upper[1])] if j > 0 else []
                lid += [(upper[1], lower[0], lower[1])] if j < chordwise - 1 else []
                surface.triangles += lid if at_tip else [(a, c, b) for a, b, c in lid]
    return surface


def sphere(triangles):
    """A sphere of radius 1 from the icosahedron, its edges cut into equal parts."""
    golden = (1 + math.sqrt(5)) / 2
    corners = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden),
               (0, -1, -golden), (0, 1, -golden), (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    parts = max(1, round(math.sqrt(triangles / 20)))
    surface, known = Surface(), {}

    def vertex(weights):
        key = tuple(sorted((c, w) for c, w in weights if w))
        if key not in known:
            p = [sum(w * corners[c][d] for c, w in key) for d in range(3)]
            size = math.sqrt(sum(x * x for x in p))
            known[key] = len(surface.vertices)
            surface.vertices.append(tuple(x / size for x in p))
        return known[key]

    for a, b, c in faces:
        def at(i, j):
            return vertex([(a, parts - i - j), (b, i), (c, j)])
        for i in range(parts):
            for j in range(parts - i):
                surface.triangles.append((at(i, j), at(i + 1, j), at(i, j + 1)))
                if i + j < parts - 1:
                    surface.triangles.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
    return surface


def bend(triangles):
    """Walls and ends of a channel with an S-bend between -1 and 1, one strip each, like those that sbend.py makes of OpenFOAM's mesh: to
    look at the case without OpenFOAM.
    """
    made, n = Surface(), max(8, round(triangles / 14))

    def wall_height(x):
        s = min(max((x + 1) / 2, 0.0), 1.0)
        return -0.2 * s**3 * (10 - 15 * s + 6 * s * s)

    def strip(points):
        first = len(made.vertices)
        for x, y in points:
            made.vertices += [(x, y, 0.0), (x, y, 0.1)]
        for k in range(first, len(made.vertices) - 2, 2):
            made.triangles += [(k, k + 2, k + 3), (k, k + 3, k + 1)]
    places = [-1 + 2 * k / n for k in range(n + 1)]
    for name, up, xs in (("lower", 0.0, places), ("upper", 0.38, places[::-1])):
        made.groups.append((name, len(made.triangles)))
        strip([(x, wall_height(x) + up) for x in xs])
    made.groups.append(("sideWall", len(made.triangles)))
    for begin, end in ((-3.0, -1.0), (1.0, 3.8)):
        xs = [begin + (end - begin) * k / n for k in range(n + 1)]
        strip([(x, wall_height(x)) for x in xs])
        strip([(x, wall_height(x) + 0.38) for x in xs[::-1]])
    for name, x, heights in (("Inlet", -3.0, (0.38, 0.19, 0.0)), ("Outlet", 3.8, (-0.2, -0.01, 0.18))):
        made.groups.append((name, len(made.triangles)))
        strip([(x, y) for y in heights])
    return welded(made)


def welded(surface):
    """Vertices at the same place are one."""
    made, number = Surface(), {}
    made.groups = surface.groups
    rows = [number.setdefault(tuple(round(c, 12) + 0.0 for c in v), len(number)) for v in surface.vertices]
    made.vertices = list(number)
    made.triangles = [tuple(rows[k] for k in t) for t in surface.triangles]
    return made


KINDS = {
    "sbend": bend,
    "cylinder_with_cones": lambda n: slender(cylinder_with_cones, n),
    "bumped_spindle": lambda n: slender(bumped_spindle, n),
    "cone_and_cylinder": lambda n: slender(cone_and_cylinder, n, True),
    "bumped_ogive": lambda n: slender(bumped_ogive, n, True),
    **{f"nose_{exponent}": lambda n, exponent=exponent: nose(exponent, n) for exponent in (0.6, 0.64, 0.68, 0.72, 0.75, 0.76, 1)},
    "wing_panels": wing_panels,
    "onera_m6": onera_m6,
    "sphere": sphere,
    **{f"frustum_{height}": lambda n, height=height: frustum(height, n) for height in (0.4, 0.7, 1, 1.5, 2)},
    "wing_6_12": lambda n: rectangular_wing(6.12, n),
    "wing_10": lambda n: rectangular_wing(10, n),
    "wing_raised": lambda n: rectangular_wing(10, n, 0.2),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kind", choices=sorted(KINDS))
    parser.add_argument("--triangles", type=int, default=8000, help="about so many")
    parser.add_argument("-o", "--out", required=True, help="OBJ file")
    options = parser.parse_args()
    KINDS[options.kind](options.triangles).write(options.out)


if __name__ == "__main__":
    main()
