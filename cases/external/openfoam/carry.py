"""Between the surface that Strake deforms and a mesh whose boundary lies on it.

A point of the mesh's boundary takes the displacement of the closest point of the start surface, linear within the
triangle: d = W D with D the displacements of the vertices. What comes back is the transpose of that.
"""
import numpy as np


def closest_on_triangles(p, a, b, c):
    """Barycentric coordinates of the points of triangles (a, b, c) that are closest to p; all n x 3.
    Regions of the plane as in Ericson, "Real-Time Collision Detection", 2005, section 5.1.5."""
    ab, ac, ap, bp, cp = b - a, c - a, p - a, p - b, p - c
    dot = lambda u, v: np.einsum("ij,ij->i", u, v)
    d1, d2, d3, d4, d5, d6 = dot(ab, ap), dot(ac, ap), dot(ab, bp), dot(ac, bp), dot(ab, cp), dot(ac, cp)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    ratio = lambda u, v: u / np.where(v == 0, 1, v)
    one, zero = np.ones(len(p)), np.zeros(len(p))
    stack = lambda u, v, w: np.stack([u, v, w], axis=1)
    t, s, r = ratio(d1, d1 - d3), ratio(d2, d2 - d6), ratio(d4 - d3, (d4 - d3) + (d5 - d6))
    inside = ratio(np.stack([va, vb, vc], axis=1), (va + vb + vc)[:, None])
    cases = [((d1 <= 0) & (d2 <= 0), stack(one, zero, zero)), ((d3 >= 0) & (d4 <= d3), stack(zero, one, zero)),
             ((vc <= 0) & (d1 >= 0) & (d3 <= 0), stack(1 - t, t, zero)),
             ((d6 >= 0) & (d5 <= d6), stack(zero, zero, one)),
             ((vb <= 0) & (d2 >= 0) & (d6 <= 0), stack(1 - s, zero, s)),
             ((va <= 0) & (d4 - d3 >= 0) & (d5 - d6 >= 0), stack(zero, 1 - r, r))]
    weights, open_ = inside, np.ones(len(p), dtype=bool)
    for holds, values in cases:
        take = open_ & holds
        weights[take] = values[take]
        open_ &= ~holds
    return weights


class SurfaceMap:
    """W: `corners` (n x 3 vertex numbers) and `weights` (n x 3), one row for each boundary point."""

    def __init__(self, corners, weights, num_vertices):
        self.corners, self.weights, self.num_vertices = corners, weights, num_vertices

    @classmethod
    def between(cls, vertices, triangles, points, candidates=16):
        """The map for boundary points near the surface; also the largest distance between the two.
        Looked at are the triangles around the `candidates` vertices that are nearest to each point."""
        fans = [[] for _ in range(len(vertices))]
        for t, corners in enumerate(triangles):
            for k in corners:
                fans[k].append(t)
        squares = np.einsum("ij,ij->i", vertices, vertices)
        corners, weights, worst = np.zeros((len(points), 3), dtype=int), np.zeros((len(points), 3)), 0.0
        count = min(candidates, len(vertices))
        for n, p in enumerate(points):
            near = np.argpartition(squares - 2 * vertices @ p, count - 1)[:count]
            some = np.array(sorted({t for k in near for t in fans[k]}))
            a, b, c = (vertices[triangles[some, k]] for k in range(3))
            w = closest_on_triangles(np.broadcast_to(p, a.shape), a, b, c)
            distance = np.linalg.norm(w[:, :1] * a + w[:, 1:2] * b + w[:, 2:] * c - p, axis=1)
            best = int(np.argmin(distance))
            corners[n], weights[n], worst = triangles[some[best]], w[best], max(worst, distance[best])
        return cls(corners, weights, len(vertices)), worst

    def apply(self, at_vertices):
        """W D: what the boundary points get of vertex displacements (vertices x 3)."""
        return np.einsum("ij,ijk->ik", self.weights, at_vertices[self.corners])

    def transpose(self, at_points):
        """W^T g: what derivatives by the boundary points (n x 3) are by the vertices."""
        out = np.zeros((self.num_vertices, 3))
        for k in range(3):
            np.add.at(out, self.corners[:, k], self.weights[:, k:k + 1] * at_points)
        return out
