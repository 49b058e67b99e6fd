"""A mesh that fits the half wing of `make_surface wing`: sheets of points stand around its sections, C-shaped with the wake behind
the trailing edge, and turn with the rounded tip until the upper and the lower half meet beyond it. A subclass of Layout may have another
section on the same planform.

Numbers of points: i from the outlet along the wake to the trailing edge, along the lower side to the leading edge, back on the
upper side and out again; j from the root to the tip and around it; k outward. Lines of points leave the wing along its
normals. Twice the numbers of cells are twice the resolution, the thickness of the cells at the wall included.
"""
import numpy as np

import around
from carry import SurfaceMap

ROOT, SPAN, TAPER, SWEEP, THICKNESS = 0.8059, 1.1963, 0.562, np.tan(np.radians(30)), 0.098  # of make_surface wing
CENTRE, RADIUS, OUTLET = 1.0, 6.0, 7.0  # the outer boundary: half circles about x = CENTRE, and straight behind it to x = OUTLET


def half_thickness(x):
    """Of the section, over the chord."""
    return 5 * THICKNESS * (0.2969 * np.sqrt(x) + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - x * 0.1036))))


class Layout:
    """Numbers of cells: chord (of each side), wake, span, tip (around it, a quarter of a circle), outward; first: thickness of the
    cells at the wall."""

    def __init__(self, sizes, first):
        self.chord, self.wake, self.span, self.tip, self.outward = (int(sizes[n]) for n in ("chord", "wake", "span", "tip", "outward"))
        self.first = first
        self.counts = 2 * (self.chord + self.wake), self.span + self.tip, self.outward
        i, j, k = np.meshgrid(*(np.arange(n + 1) for n in self.counts), indexing="ij")
        last = self.counts[0]
        other = np.minimum(i, last - i)  # its mirror image in z
        wake = (k == 0) & (other <= self.wake)
        row = np.where((wake | (2 * i == last)) & (j > self.span), self.span, j)  # the tip has no radius there
        column = np.where(wake | (j == self.counts[1]), other, i)
        name = (column * (self.counts[1] + 1) + row) * (self.outward + 1) + k
        _, self.rows, number = np.unique(name, return_index=True, return_inverse=True)
        self.number = number.reshape(name.shape)

    def section(self, x):
        """Half thickness over the chord at these places along it."""
        return half_thickness(x)

    def along(self, m):
        """Places along the chord, close at the leading edge, of shares of the cells."""
        return 0.45 * (m ** 2 + m ** 4) + 0.05 * (1 - np.cos(np.pi * m))

    def lean(self, m, x):
        """How much of the section's slope the lines follow that leave it: at the trailing edge as in the wake, not at all."""
        return 1 - m ** 6

    def upper(self):
        """Inner points, outer points and directions in which the lines leave, of the upper half from the leading edge to the outlet."""
        m = np.arange(self.chord + 1) / self.chord
        along = self.along(m)
        station = np.arange(self.span + 1) / self.span
        station = station + 0.12 * np.sin(np.pi * station)  # closer at the tip
        y = SPAN * np.concatenate([station, np.ones(self.tip)])
        turn = 0.5 * np.pi * np.concatenate([np.zeros(self.span), np.arange(self.tip + 1) / self.tip])
        chord = ROOT * (1 + y / SPAN * (TAPER - 1))
        up = np.stack([0 * turn, np.sin(turn), np.cos(turn)], axis=1)
        up[-1], up[turn == 0] = (0, 1, 0), (0, 0, 1)
        thick = self.section(along)
        thick[[0, -1]] = 0
        axis = np.stack(np.broadcast_arrays(y * SWEEP + chord * along[:, None], y, 0), axis=-1)
        wing = axis + (chord * thick[:, None])[..., None] * up
        slope = np.gradient(self.section(np.linspace(0, 1, 2001)), 1 / 2000)
        slope = np.interp(along, np.linspace(0, 1, 2001), slope) * self.lean(m, along)
        away = np.stack([-slope[1:], np.ones(self.chord)], axis=1)
        away = np.vstack([[-1, 0], away / np.linalg.norm(away, axis=1)[:, None]])
        leave = away[:, :1, None] * [1, 0, 0] + away[:, 1:, None] * up
        far = 0.5 * np.pi * np.arange(len(y)) / (len(y) - 1)
        spread = np.stack([0 * far, np.sin(far), np.cos(far)], axis=1)
        spread[-1], spread[0] = (0, 1, 0), (0, 0, 1)
        centre = np.stack([np.full(len(y), CENTRE), y, 0 * y], axis=1)
        angle = 0.5 * np.pi * m[:, None, None]
        outer = centre + RADIUS * (np.sin(angle) * spread - np.cos(angle) * np.array([1.0, 0, 0]))
        w = np.arange(1, self.wake + 1) / self.wake
        w = (np.expm1(3.5 * w) / np.expm1(3.5))[:, None, None]
        behind = wing[-1] + w * (OUTLET - wing[-1, :, :1]) * [1, 0, 0]
        outer_behind = outer[-1] + w * (OUTLET - CENTRE) * np.array([1.0, 0, 0])
        return (np.concatenate([wing, behind]), np.concatenate([outer, outer_behind]),
                np.concatenate([leave, np.broadcast_to(up, behind.shape)]))

    def wing(self, surface):
        """The map from a surface (vertices, triangles) to the points on the wing, in rows as `points` wants them."""
        inner = mirrored(self.upper()[0][:self.chord + 1]).reshape(-1, 3)
        carried, worst = SurfaceMap.between(*surface, inner)
        at = carried.apply(surface[0])
        for axis in (1, 2):  # of the symmetry plane, and of the edges in the plane z = 0
            at[np.abs(inner[:, axis]) < 1e-12, axis] = 0
        return carried, at, worst

    def points(self, on_wing):
        """All points of the mesh about a wing, in the order of their numbers; the wake begins where the trailing edge is."""
        inner, outer, leave = (mirrored(part) for part in self.upper())
        wing = slice(self.wake, self.wake + 2 * self.chord + 1)
        on_wing = on_wing.reshape(inner[wing].shape)
        edge, inner[wing] = on_wing[0] - inner[self.wake], on_wing
        fade = np.append((OUTLET - inner[:self.wake, :1, 0]) / (OUTLET - on_wing[0, 0, 0]), 1)[:-1, None, None]
        inner[:self.wake] += fade * edge
        inner[wing.stop:] += (fade * edge)[::-1]
        reach = 0.35 * np.linalg.norm(outer - inner, axis=2)
        first = self.first * (1 + 8 * np.maximum(inner[..., 0] - on_wing[0, :, 0], 0))  # thicker in the wake
        s = around.graded(np.minimum(0.5 * first / reach, 1), self.outward)[..., None]
        by = inner + reach[..., None] * leave
        out = (1 - s) ** 2 * inner[:, :, None] + 2 * s * (1 - s) * by[:, :, None] + s ** 2 * outer[:, :, None]
        return out.reshape(-1, 3)[self.rows]


def mirrored(upper):
    """Lower half, from the outlet to the leading edge, and upper half of rows of points."""
    return np.concatenate([(upper * [1, 1, -1])[:0:-1], upper])


def write_topology(mesh, layout, points):
    """All of a polyMesh folder but the points, which `foam.write_points` writes."""
    node, counts = layout.number, layout.counts
    cell = np.arange(np.prod(counts)).reshape(counts)
    at = np.stack([points[node[i:counts[0] + i, j:counts[1] + j, k:counts[2] + k]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    middle = at.mean(axis=0).reshape(-1, 3)
    inside, outside = [], {"far": [], "symmetry": [], "body": []}
    none = lambda owner: np.full(owner.shape, -1)
    for axis in range(3):
        quads, before, after = around.faces_across(node, cell, axis)
        inside.append((quads[1:-1], before[1:], after[:-1]))
        first, last = (quads[0], after[0]), (quads[-1], before[-1])
        if axis == 0:
            for row, owner in (first, last):
                outside["far"].append((row, owner, none(owner)))
        elif axis == 1:
            outside["symmetry"].append((*first, none(first[1])))
            half = counts[0] // 2
            row, owner = last  # [i, k, 4], where upper and lower half meet beyond the tip
            inside.append((row[:half], owner[:half], owner[::-1][:half]))
        else:
            outside["far"].append((*last, none(last[1])))
            row, owner = first
            wing = slice(layout.wake, counts[0] - layout.wake)
            outside["body"].append((row[wing], owner[wing], none(owner[wing])))
            inside.append((row[:layout.wake], owner[:layout.wake], owner[::-1][:layout.wake]))
    parts = {name: around.joined(rows, points, middle) for name, rows in [("", inside), *outside.items()]}
    quads, owner, neighbour = parts[""]
    order = np.lexsort((neighbour, owner))
    parts[""] = quads[order], owner[order], neighbour[order]
    around.write_parts(mesh, parts)
