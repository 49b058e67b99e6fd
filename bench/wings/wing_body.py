#!/usr/bin/python3
"""Half a supersonic wing-body, open at y = 0: a body of length 1 that blends into a swept wing. OBJ file."""
import argparse
import math

ROOT, TIP = 0.09, 0.5  # where the body ends, semispan


def section(y):
    """Leading edge, chord, t/c at a place along the span."""
    eta = max(0.0, (y - ROOT) / (TIP - ROOT))
    front, chord, thickness = 0.34 + 0.36 * (y - ROOT) / (TIP - ROOT), 0.44 * (1 - 0.62 * eta), 0.05
    body = math.cos(math.pi / 2 * y / ROOT) ** 2 if y < ROOT else 0.0
    return front + body * (0 - front), chord + body * (1 - chord), thickness + body * 0.05


def half_thickness(t, x):
    return 5 * t * (0.2969 * math.sqrt(x) - 0.126 * x - 0.3516 * x ** 2 + 0.2843 * x ** 3 - 0.1036 * x ** 4)


def surface(triangles):
    around = max(24, 2 * round(math.sqrt(triangles / 2)))
    rows = max(12, round(triangles / (2 * around)))
    inner = rows // 3
    places = [ROOT * k / inner for k in range(inner)] + [ROOT + (TIP - ROOT) * k / (rows - inner) for k in range(rows - inner + 1)]
    n = around // 2
    vertices, faces = [], []
    for y in places:
        front, chord, t = section(y)
        for k in range(around):
            x = (1 + math.cos(2 * math.pi * k / around)) / 2
            z = 0.0 if k in (0, n) else math.copysign(half_thickness(t, x), n - k)
            vertices.append((front + chord * x, y, chord * z))
    for r in range(len(places) - 1):
        for k in range(around):
            a, b = r * around + k, r * around + (k + 1) % around
            faces += [(a, a + around, b), (b, a + around, b + around)]
    first = (len(places) - 1) * around
    for k in range(n):  # the tip is flat
        upper, after, lower, below = first + k, first + k + 1, first + (around - k) % around, first + around - k - 1
        faces += [(upper, lower, after)] if k > 0 else []
        faces += [(after, lower, below)] if k < n - 1 else []
    return vertices, faces


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=5000, help="about so many")
    parser.add_argument("-o", "--out", required=True)
    options = parser.parse_args()
    vertices, faces = surface(options.triangles)
    with open(options.out, "w") as out:
        out.writelines(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in vertices)
        out.writelines(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces)


if __name__ == "__main__":
    main()
