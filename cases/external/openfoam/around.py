"""A mesh that fits a slender body, pointed at both ends, for a supersonic stream along x: half of the space, y > 0.

Lines of points leave the body outward; the first one leaves its nose, upstream, and some follow in the wake. They end on a cone
that has to lie outside of the bow shock. Sheets of lines stand around the axis, from below to above. So the cells are where the
waves are, the mesh follows from the surface alone, without a mesher and its noise, and twice the numbers of cells are exactly
twice the resolution. The sections of the body have to be visible from its axis, the line y = z = 0.
"""
import os

import numpy as np

import foam

KINDS = {"inlet": "patch", "outlet": "patch", "symmetry": "symmetryPlane", "front": "wedge", "back": "wedge", "body": "wall"}
ORDER = list(KINDS)  # of the patches in a mesh


class Layout:
    """Numbers of cells: along the body, in the wake behind it, around the half, and outward. ends: where along x the body begins and
    ends; slope: of the outer cone's radius over x."""

    def __init__(self, sizes, ends, slope):
        self.along, self.wake, self.around, self.outward = (int(sizes[name]) for name in ("along", "wake", "around", "outward"))
        self.ends, self.slope = ends, slope
        i, j, k = np.meshgrid(*(np.arange(n + 1) for n in self.counts()), indexing="ij")
        merged = np.where((i == 0) | ((k == 0) & (i >= self.along)), 0, j)  # these lie on the axis
        name = (i * (self.around + 1) + merged) * (self.outward + 1) + k
        self.kept, number = np.unique(name, return_inverse=True)
        self.number = number.reshape(name.shape)

    def counts(self):
        return self.along + self.wake, self.around, self.outward

    def stations(self):
        """Where lines leave the body and the wake, along x: closer at the ends of the body. The share of the body."""
        t = np.arange(self.along + 1) / self.along
        body = 0.3 * t + 0.35 * (1 - np.cos(np.pi * t))
        w = np.arange(1, self.wake + 1) / self.wake
        return np.concatenate([body, 1 + 0.25 * np.expm1(2.5 * w) / np.expm1(2.5)])

    def points(self, surface):
        """All points of the mesh about a surface (vertices, triangles), in the order of their numbers."""
        low, high = self.ends
        length, share = high - low, self.stations()
        x, angle = low + length * share, np.pi * np.arange(self.around + 1) / self.around
        across = np.stack([0 * angle, np.sin(angle), -np.cos(angle)], axis=1)
        across[[0, -1], 1] = 0
        radius = np.zeros((len(x), len(angle)))
        radius[1:self.along] = radii(*surface, x[1:self.along], across)
        # A polygon lies within its circle; so that it has the circle's area:
        radius *= np.sqrt(np.pi / self.around / np.sin(np.pi / self.around))
        inner = x[:, None, None] * [1, 0, 0] + radius[:, :, None] * across
        ahead = 0.06 * (1 - np.exp(-share / 0.06))
        outer_radius = self.slope * np.sqrt((share + ahead) * (share + ahead + 0.12))
        outer = ((x + length * (ahead - 0.06))[:, None, None] * [1, 0, 0] + length * outer_radius[:, None, None] * across)
        first = 0.8 / self.along / np.linalg.norm(outer - inner, axis=2) * length
        out = inner[:, :, None] + graded(np.minimum(first, 1), self.outward)[..., None] * (outer - inner)[:, :, None]
        flat = np.empty((len(self.kept), 3))
        flat[self.number.ravel()] = out.reshape(-1, 3)
        return flat


def graded(first, count):
    """Numbers from 0 to 1 in `count` steps that grow by equal factors, the first of them `first` (an array) if that is not much above the mean."""
    low, high = np.full(first.shape, -2.0), np.full(first.shape, 12.0)
    step = lambda a: np.where(np.abs(a) < 1e-9, 1 / count, np.expm1(a / count) / np.where(np.abs(a) < 1e-9, 1, np.expm1(a)))
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = step(middle) > first
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    grow = 0.5 * (low + high)[..., None]
    return np.expm1(grow * np.arange(count + 1) / count) / np.expm1(grow)


def radii(vertices, triangles, stations, across):
    """Distance of the surface from the axis at each station along x and in each direction across, stations x directions."""
    corners = vertices[triangles]
    low, high = corners[:, :, 0].min(axis=1), corners[:, :, 0].max(axis=1)
    out = np.empty((len(stations), len(across)))
    for n, x in enumerate(stations):
        x = x + 1e-12 * np.ptp(vertices[:, 0])  # past vertices that lie there
        cut = corners[(low < x) & (high > x)]
        if not len(cut):
            foam.fail(f"the surface has no section at x = {x:.6g}")
        out[n] = section(cut, x, across[:, 1:])
    return out


def section(corners, x, directions):
    """The farthest crossing of rays from the axis with the triangles' cut at x."""
    ends = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        p, q = corners[:, a], corners[:, b]
        crosses = (p[:, 0] < x) != (q[:, 0] < x)
        t = (x - p[:, 0]) / np.where(crosses, q[:, 0] - p[:, 0], 1)
        ends.append(np.where(crosses[:, None], p[:, 1:] + t[:, None] * (q - p)[:, 1:], np.nan))
    ends = np.stack(ends, axis=1)
    p = np.where(np.isnan(ends[:, 0]), ends[:, 1], ends[:, 0])
    q = np.where(np.isnan(ends[:, 2]), ends[:, 1], ends[:, 2])
    turned = np.stack([-directions[:, 1], directions[:, 0]], axis=1)
    side_p, side_q = p @ turned.T, q @ turned.T  # segments x rays
    slack = 1e-9 * np.abs(p).max()
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.clip(np.where(side_p == side_q, 0, side_p / (side_p - side_q)), 0, 1)
    away = (1 - t) * (p @ directions.T) + t * (q @ directions.T)
    away[(side_p > slack) & (side_q > slack) | (side_p < -slack) & (side_q < -slack)] = -np.inf
    found = away.max(axis=0)
    if not np.all(found > 0):
        foam.fail(f"the section at x = {x:.6g} is not visible from the axis")
    return found


def write_topology(mesh, layout, points):
    """All of a polyMesh folder but the points, which `foam.write_points` writes."""
    write_block(mesh, layout.number, points, ((None, "outlet"), ("symmetry", "symmetry"), ("body", "inlet")))


def write_block(mesh, node, points, patches):
    """The same of a block of cells whose points have the numbers `node`; patches: names at the low and the high end of each axis.
    Points may coincide: faces without area are left out."""
    counts = tuple(n - 1 for n in node.shape)
    cell = np.arange(np.prod(counts)).reshape(counts)
    at = np.stack([points[node[i:counts[0] + i, j:counts[1] + j, k:counts[2] + k]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    middle = at.mean(axis=0).reshape(-1, 3)
    inside, outside = [], {name: [] for name in ORDER if any(name in pair for pair in patches)}
    for axis in range(3):
        quads, before, after = faces_across(node, cell, axis)
        inside.append((quads[1:-1], before[1:], after[:-1]))
        for patch, row, owner in ((patches[axis][0], quads[0], after[0]), (patches[axis][1], quads[-1], before[-1])):
            if patch:
                outside[patch].append((row, owner, np.full(owner.shape, -1)))
    parts = {name: joined(rows, points, middle) for name, rows in [("", inside), *outside.items()]}
    quads, owner, neighbour = parts[""]
    order = np.lexsort((neighbour, owner))
    parts[""] = quads[order], owner[order], neighbour[order]
    write_parts(mesh, parts)


def faces_across(node, cell, axis):
    """The faces between the cells along one axis: corner numbers [place, .., 4], cells before and after each inner place."""
    node, cell = np.moveaxis(node, axis, 0), np.moveaxis(cell, axis, 0)
    quads = np.stack([node[:, :-1, :-1], node[:, 1:, :-1], node[:, 1:, 1:], node[:, :-1, 1:]], axis=-1)
    return quads, cell, cell


def joined(rows, points, middle):
    """Faces in one list, those without area left out, with normals that leave the owner, the cell of smaller number."""
    quads, owner, neighbour = (np.concatenate([row[k].reshape((-1, 4) if k == 0 else -1) for row in rows]) for k in range(3))
    swap = (neighbour >= 0) & (neighbour < owner)
    owner, neighbour = np.where(swap, neighbour, owner), np.where(swap, owner, neighbour)
    same = quads == np.roll(quads, -1, axis=1)
    some = same.sum(axis=1) < 2
    quads, owner, neighbour = quads[some], owner[some], neighbour[some]
    corners = points[quads]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    inward = np.einsum("ij,ij->i", normal, corners.mean(axis=1) - middle[owner]) < 0
    quads[inward] = quads[inward, ::-1]
    return quads, owner, neighbour


def write_parts(mesh, parts):
    os.makedirs(mesh, exist_ok=True)
    quads, owner, neighbour = (np.concatenate([part[k] for part in parts.values()]) for k in range(3))
    lines = []
    for quad in quads.tolist():
        face = [n for k, n in enumerate(quad) if n != quad[k - 1]]
        lines.append(f"{len(face)}({' '.join(map(str, face))})")
    inner = len(parts[""][1])
    for name, kind, rows in (("faces", "faceList", lines), ("owner", "labelList", owner.tolist()),
                             ("neighbour", "labelList", neighbour[:inner].tolist())):
        with open(os.path.join(mesh, name), "w", encoding="ascii") as file:
            file.write(foam.header(kind, name) + f"{len(rows)}\n(\n" + "\n".join(map(str, rows)) + "\n)\n")
    start, entries = inner, []
    for name, (rows, _, _) in parts.items():
        if name:
            entries.append(f"{name} {{ type {KINDS.get(name, 'patch')}; nFaces {len(rows)}; startFace {start}; }}")
            start += len(rows)
    with open(os.path.join(mesh, "boundary"), "w", encoding="ascii") as file:
        file.write(foam.header("polyBoundaryMesh", "boundary") + f"{len(entries)}\n(\n" + "\n".join(entries) + "\n)\n")
