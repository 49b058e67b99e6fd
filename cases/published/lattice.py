#!/usr/bin/python3
"""Vortex lattice of half a wing: lattice.py START.obj REQUEST RESULT [CHORDWISE SPANWISE], as Strake calls it; the
lattice has 4 x 24 rings unless the last two say otherwise.

Values: lift and drag coefficients and span efficiency, lift^2 / (pi A drag); A and the reference area are those of START.
START is the wing at rest, its root in the plane y = 0 and its sections across y. The lattice lies halfway between its two sides;
every point of it follows the triangles above and below it, so that the lattice is a fixed linear map of the vertices.

Rings of vortices with a wake along x, mirrored at y = 0; flow of speed 1 at the angle `alpha` of the case's variables; lift and drag
from the wake far behind (Trefftz plane). Derivatives by vertices and by alpha come from one adjoint solve for each value.
"""
import json
import sys

import numpy as np

from obj import read_obj

WAKE = 1e4  # its length
MIRROR = np.array([1.0, -1.0, 1.0])


def divide(chordwise, spanwise):
    """Numbers of rings. Edges and middles of the strips, in halves of the span, are equidistant on a quarter of a circle from root to
    tip: the flow there of vortices at the edges is exact for loads that are sines of few waves on that circle, the elliptic one first.
    """
    global CHORDWISE, SPANWISE, EDGES, MIDDLE
    CHORDWISE, SPANWISE = chordwise, spanwise
    EDGES = np.sin(np.pi / 2 * np.arange(spanwise + 1) / spanwise)
    MIDDLE = ((np.sin(np.pi / 2 * (np.arange(spanwise) + 0.5) / spanwise) - EDGES[:-1]) / np.diff(EDGES))[:, None]


divide(4, 24)


def sheet(vertices, triangles, points):
    """Weights (points x vertices) of the places halfway between the uppermost and the lowest triangle at x, y."""
    weights = np.zeros((len(points), len(vertices)))
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    det = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    flat = abs(det) < 1e-12
    det[flat] = 1
    for number, (x, y) in enumerate(points):
        u = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (y - a[:, 1])) / det
        v = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])) / det
        inside = np.minimum(np.minimum(u, v), 1 - u - v)
        inside[flat] = -1
        hit = np.flatnonzero(inside > -1e-9)
        if not len(hit):
            sys.exit(f"no triangle of the wing at x = {x}, y = {y}: is the root at y = 0?")
        z = a[hit, 2] + u[hit] * (b[hit, 2] - a[hit, 2]) + v[hit] * (c[hit, 2] - a[hit, 2])
        for t in (hit[np.argmax(z)], hit[np.argmin(z)]):
            weights[number, triangles[t]] += 0.5 * np.array([1 - u[t] - v[t], u[t], v[t]])
    return weights


def lattice_points(vertices):
    """x, y of the lattice at rest, rows from the leading edge back; the chord is that of the vertices at each place of the span."""
    tip = vertices[:, 1].max()
    y = tip * EDGES
    stations = np.unique(np.round(vertices[:, 1], 9))
    ends = np.array([[f(vertices[abs(vertices[:, 1] - s) < 1e-8, 0]) for f in (np.min, np.max)] for s in stations])
    front, back = np.interp(y, stations, ends[:, 0]), np.interp(y, stations, ends[:, 1])
    k = np.arange(CHORDWISE + 1)[:, None] / CHORDWISE
    x = front + (back - front) * (1 - np.cos(np.pi * k)) / 2
    area = 2 * float(np.sum(np.diff(y) * (back - front)[1:] / 2 + np.diff(y) * (back - front)[:-1] / 2))
    return np.stack([x, np.broadcast_to(y, x.shape)], 2).reshape(-1, 2), area, 4 * tip**2 / area


def segment(c, p, q):
    """Velocity at c by a straight vortex of strength 1 from p to q, and what its derivative needs."""
    r1, r2 = c - p, c - q
    a, b, dot = np.linalg.norm(r1, axis=-1), np.linalg.norm(r2, axis=-1), np.sum(r1 * r2, -1)
    D = a * b * (a * b + dot)
    k = (a + b) / (4 * np.pi * D)
    return k[..., None] * np.cross(r1, r2), (r1, r2, a, b, dot, D, k)


def segment_back(kept, pull):
    """Derivatives of pull . velocity by r1 and r2."""
    r1, r2, a, b, dot, D, k = kept
    by_w, by_k = k[..., None] * pull, np.sum(np.cross(r1, r2) * pull, -1)
    by_D = -k / D * by_k
    by_a = by_k / (4 * np.pi * D) + by_D * (2 * a * b**2 + b * dot)
    by_b = by_k / (4 * np.pi * D) + by_D * (2 * a**2 * b + a * dot)
    by_dot = by_D * a * b
    return (np.cross(r2, by_w) + (by_a / a)[..., None] * r1 + by_dot[..., None] * r2,
            np.cross(by_w, r1) + (by_b / b)[..., None] * r2 + by_dot[..., None] * r1)


class Lattice:
    def __init__(self, points, alpha):
        """points: lattice, (CHORDWISE + 1) x (SPANWISE + 1) x 3"""
        m, n = CHORDWISE, SPANWISE
        self.points, self.stream = points, np.array([np.cos(alpha), 0, np.sin(alpha)])
        self.by_alpha = np.array([-np.sin(alpha), 0, np.cos(alpha)])
        rings = np.concatenate([points[:-1] + 0.25 * np.diff(points, axis=0), points[-1:] + 0.25 * (points[-1:] - points[-2:-1]),
                                points[-1:] + 0.25 * (points[-1:] - points[-2:-1]) + [WAKE, 0, 0]])
        # Corners of the rings, around; those of the last row stand for the wake, of the strength of the row before it.
        self.corner = np.stack([rings[:-1, :-1], rings[:-1, 1:], rings[1:, 1:], rings[1:, :-1]], 2).reshape(-1, 4, 3)
        at = 0.75 * points[1:] + 0.25 * points[:-1]
        self.at = (at[:, 1:] * MIDDLE + at[:, :-1] * (1 - MIDDLE)).reshape(-1, 3)
        self.d1 = (points[1:, 1:] - points[:-1, :-1]).reshape(-1, 3)
        self.d2 = (points[:-1, 1:] - points[1:, :-1]).reshape(-1, 3)
        self.normal = np.cross(self.d1, self.d2)
        self.kept, speed = [], 0
        for mirror, sign in ((np.ones(3), 1), (MIRROR, -1)):
            corner = self.corner * mirror
            for k in range(4):
                own, kept = segment(self.at[:, None], corner[None, :, k], corner[None, :, (k + 1) % 4])
                speed = speed + sign * own
                self.kept.append((k, mirror, sign, kept))
        self.speed = speed[:, :m * n].copy()
        self.speed[:, (m - 1) * n:] += speed[:, m * n:]
        self.matrix = np.einsum("ia,ija->ij", self.normal, self.speed)
        self.strength = np.linalg.solve(self.matrix, -self.normal @ self.stream)
        # Far behind: strips of the wake between its edges.
        self.edge = rings[-2][:, 1:]  # y, z
        self.last = self.strength[(m - 1) * n:]

    def wake(self):
        """Lift and drag over the dynamic pressure; derivatives of both by the strips' strengths and the edges' y, z."""
        G, e = self.last, self.edge
        n = len(G)
        shed = np.diff(np.concatenate([[0], G, [0]]))  # by which the strength grows over each edge
        middle, along = e[1:] * MIDDLE + e[:-1] * (1 - MIDDLE), np.diff(e, axis=0)
        lift = 4 * float(np.sum(G * along[:, 0]))  # both halves, over 1/2
        by_lift, lift_by_edge = 4 * along[:, 0], np.zeros_like(e)
        lift_by_edge[1:, 0] += 4 * G
        lift_by_edge[:-1, 0] -= 4 * G
        # Flow through a strip by the edges and their images, d = place - vortex: (across . d) / (2 pi d^2).
        flow = np.zeros((n, n + 1))
        by_d = []
        for mirror, sign in ((np.array([1.0, 1.0]), 1), (np.array([-1.0, 1.0]), -1)):
            d = middle[:, None] - (e * mirror)[None]
            d2 = np.sum(d**2, -1)
            dot = np.sum(along[:, None] * d, -1)
            flow += sign * dot / (2 * np.pi * d2)
            by_d.append((mirror, sign, d, d2, dot))
        drag = 2 * float(G @ flow @ shed)
        by_flow = 2 * np.outer(G, shed)
        by_shed = 2 * G @ flow
        by_drag = 2 * flow @ shed + by_shed[:-1] - by_shed[1:]
        drag_by_edge = np.zeros_like(e)
        for mirror, sign, d, d2, dot in by_d:
            weight = sign * by_flow / (2 * np.pi * d2)
            pull = weight[..., None] * along[:, None] - (2 * weight * dot / d2)[..., None] * d
            by_along = np.sum(weight[..., None] * d, 1)
            drag_by_edge[1:] += pull.sum(1) * MIDDLE + by_along
            drag_by_edge[:-1] += pull.sum(1) * (1 - MIDDLE) - by_along
            drag_by_edge -= pull.sum(0) * mirror
        return (lift, by_lift, lift_by_edge), (drag, by_drag, drag_by_edge)

    def back(self, by_last, by_edge):
        """Derivatives by the lattice's points and by alpha of a value with these by strengths of the last row and by edges."""
        m, n = CHORDWISE, SPANWISE
        by_strength = np.zeros(m * n)
        by_strength[(m - 1) * n:] = by_last
        adjoint = np.linalg.solve(self.matrix.T, by_strength)
        by_normal = -adjoint[:, None] * (np.einsum("ija,j->ia", self.speed, self.strength) + self.stream)
        all_strengths = np.concatenate([self.strength, self.last])
        pull = -(adjoint[:, None] * self.normal)[:, None] * all_strengths[None, :, None]
        by_at, by_corner = np.zeros_like(self.at), np.zeros_like(self.corner)
        for k, mirror, sign, kept in self.kept:
            by_1, by_2 = segment_back(kept, sign * pull)
            by_at += (by_1 + by_2).sum(1)
            by_corner[:, k] -= by_1.sum(0) * mirror
            by_corner[:, (k + 1) % 4] -= by_2.sum(0) * mirror
        by_corner = by_corner.reshape(m + 1, n, 4, 3)
        by_ring = np.zeros((m + 2, n + 1, 3))
        by_ring[:-1, :-1] += by_corner[:, :, 0]
        by_ring[:-1, 1:] += by_corner[:, :, 1]
        by_ring[1:, 1:] += by_corner[:, :, 2]
        by_ring[1:, :-1] += by_corner[:, :, 3]
        by_ring[-2, :, 1:] += by_edge
        by_ring[-2] += by_ring[-1]
        by_point = np.zeros_like(self.points)
        by_point[:-1] += 0.75 * by_ring[:-2]
        by_point[1:] += 0.25 * by_ring[:-2]
        by_point[-1] += 1.25 * by_ring[-2]
        by_point[-2] -= 0.25 * by_ring[-2]
        by_at = by_at.reshape(m, n, 3)
        for side, share in ((slice(1, None), MIDDLE), (slice(None, -1), 1 - MIDDLE)):
            by_point[1:, side] += 0.75 * share * by_at
            by_point[:-1, side] += 0.25 * share * by_at
        by_1 = np.cross(self.d2, by_normal).reshape(m, n, 3)
        by_2 = np.cross(by_normal, self.d1).reshape(m, n, 3)
        by_point[1:, 1:] += by_1
        by_point[:-1, :-1] -= by_1
        by_point[:-1, 1:] += by_2
        by_point[1:, :-1] -= by_2
        return by_point, float(-adjoint @ (self.normal @ self.by_alpha))


def evaluate(start, triangles, vertices, alpha, wants_gradients=True):
    """Values, and of each its derivatives by vertices and by alpha."""
    places, area, aspect = lattice_points(start)
    weights = sheet(start, triangles, places)
    lattice = Lattice((weights @ vertices).reshape(CHORDWISE + 1, SPANWISE + 1, 3), alpha)
    (lift, *lift_by), (drag, *drag_by) = lattice.wake()
    lift, drag = lift / area, drag / area
    values = {"lift": lift, "drag": drag, "efficiency": lift**2 / (np.pi * aspect * drag)}
    gradients = {}
    if wants_gradients:
        for name, by in (("lift", lift_by), ("drag", drag_by)):
            by_point, by_alpha = lattice.back(*by)
            gradients[name] = (weights.T @ by_point.reshape(-1, 3) / area, by_alpha / area)
        e = values["efficiency"]
        gradients["efficiency"] = tuple(2 * e / lift * gradients["lift"][k] - e / drag * gradients["drag"][k] for k in range(2))
    return values, gradients


def main():
    with open(sys.argv[2], encoding="utf-8") as file:
        request = json.load(file)
    if len(sys.argv) > 4:
        divide(int(sys.argv[4]), int(sys.argv[5]))
    start, triangles = read_obj(sys.argv[1])
    wanted = request["wanted"]
    values, gradients = evaluate(start, triangles, read_obj(request["surface"])[0], request["variables"]["alpha"],
                                 bool(wanted["gradients"]))
    result = {"values": values, "gradients": {}, "variables": {}}
    for name in wanted["gradients"]:
        np.save(name + ".npy", gradients[name][0])
        result["gradients"][name] = name + ".npy"
        result["variables"][name] = {"alpha": gradients[name][1]}
    with open(sys.argv[3], "w", encoding="utf-8") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main()
