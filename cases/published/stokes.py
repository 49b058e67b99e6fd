#!/usr/bin/python3
"""Drag of a body in Stokes flow and its derivative by every vertex: stokes.py REQUEST RESULT, as Strake calls it.

The body moves along x with speed 1 through a fluid of viscosity 1. Its drag is b.f where A f = b: A is the single-layer operator
(Stokeslets) between constant tractions on the triangles, b the triangles' areas along x. A is symmetric (Galerkin's method), so the
derivative needs no further solve:  d(b.f) = 2 f.db - f.dA f.  Every integral is a fixed formula in the vertices, so the derivative
is that of the computed value, to rounding:
  - a triangle with itself: closed form (Eibert and Hansen 1995 for 1/r; the tensor r r/r^3 follows by deforming the triangle);
  - triangles within three rings of neighbours: seven points on each (which pairs, only the connectivity says);
  - all others: one point.
"""
import json
import sys

import numpy as np
from scipy import linalg, sparse

from obj import read_obj

# Radon's rule of degree 5: barycentric coordinates and weights.
ROOT = np.sqrt(15)
A1, A2, W1, W2 = (6 - ROOT) / 21, (6 + ROOT) / 21, (155 - ROOT) / 1200, (155 + ROOT) / 1200
POINTS = np.array([[1 / 3] * 3] + [[1 - 2 * a if k == j else a for k in range(3)] for a in (A1, A2) for j in range(3)])
WEIGHTS = np.array([9 / 40] + [W1] * 3 + [W2] * 3)
PAIR_WEIGHTS = np.outer(WEIGHTS, WEIGHTS).ravel()


def near_pairs(triangles, vertices):
    """Pairs i < j of triangles that are at most three rings of neighbours apart."""
    n = len(triangles)
    touches = sparse.csr_matrix((np.ones(3 * n), (np.repeat(np.arange(n), 3), triangles.ravel())), shape=(n, vertices))
    ring = touches @ touches.T
    pairs = sparse.triu(ring @ ring @ ring, 1).tocoo()
    return pairs.row, pairs.col


def own(edges, area):
    """Blocks of the triangles with themselves, and what their derivative needs. edges: n x 3 x 3, area: n."""
    l = np.linalg.norm(edges, axis=2)
    P = l.sum(1, keepdims=True)
    q = P - 2 * l
    log = np.log(P / q)
    sign = 1 - 2 * np.eye(3)
    g = 4 / 3 * np.sum(log / l, 1)
    g1 = 4 / 3 * (-log / l**2 + np.sum(1 / l, 1, keepdims=True) / P - np.einsum("ti,ik->tk", 1 / (l * q), sign))
    first = 1 / P[:, :, None] - sign / q[:, :, None]  # of ln(P / q_k) by l_m
    g2 = 4 / 3 * (2 * np.einsum("tk,km->tkm", log / l**3, np.eye(3)) - first / l[:, :, None] ** 2
                  - (first / l[:, :, None] ** 2).transpose(0, 2, 1)
                  + (np.einsum("ti,ik,im->tkm", 1 / (l * q**2), sign, sign) - (np.sum(1 / l, 1) / P[:, 0] ** 2)[:, None, None]))
    tensor = g[:, None, None] * np.eye(3) - np.einsum("tk,tki,tkj->tij", g1 / l, edges, edges)
    return area[:, None, None] ** 2 * tensor, l, g1, g2, tensor


def own_gradient(f, edges, area, l, g1, g2, tensor):
    """f.dA f of the triangles with themselves, by edge vectors and by areas."""
    along = np.einsum("ti,tki->tk", f, edges)  # f.e
    f2 = np.sum(f**2, 1, keepdims=True)
    by_length = f2 * g1 - np.einsum("tkm,tk->tm", g2, along**2 / l) + g1 * along**2 / l**2
    by_edge = (by_length / l)[:, :, None] * edges - 2 * (g1 / l * along)[:, :, None] * f[:, None, :]
    return area[:, None, None] ** 2 * by_edge, 2 * area * np.einsum("ti,tij,tj->t", f, tensor, f)


def by_difference(d, p, q):
    """Derivative of p.G(d) q by d."""
    inverse = 1 / np.sqrt(np.sum(d**2, -1))
    e = d * inverse[..., None]
    pe, qe, pq = np.sum(p * e, -1), np.sum(q * e, -1), np.sum(p * q, -1)
    return inverse[..., None] ** 2 * ((-pq - 3 * pe * qe)[..., None] * e + qe[..., None] * p + pe[..., None] * q)


class Body:
    def __init__(self, vertices, triangles):
        self.v, self.t = vertices, triangles
        corner = vertices[triangles]
        self.edges = np.roll(corner, -2, 1) - np.roll(corner, -1, 1)  # opposite of each corner
        self.normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        self.area = np.linalg.norm(self.normal, axis=1) / 2
        self.centroid = corner.mean(1)
        self.points = np.einsum("pk,tki->tpi", POINTS, corner)
        self.i, self.j = near_pairs(triangles, len(vertices))

    def near(self):
        """Differences between the points of near pairs, three of pairs x 49, in pieces that stay in the processor's cache."""
        for begin in range(0, len(self.i), 500):
            i, j = self.i[begin:begin + 500], self.j[begin:begin + 500]
            yield i, j, [(self.points[i, :, None, c] - self.points[j, None, :, c]).reshape(len(i), 49) for c in range(3)]

    def summed(self, triangles, rows):
        """Per triangle, the sum of its rows."""
        return sparse.csr_matrix((np.ones(len(rows)), triangles, np.arange(len(rows) + 1)), shape=(len(rows), len(self.t))).T @ rows

    def far(self, rows):
        """Differences between these centroids and all, three of rows x n, and one over their lengths."""
        d = [self.centroid[rows, c, None] - self.centroid[None, :, c] for c in range(3)]
        square = d[0] ** 2 + d[1] ** 2 + d[2] ** 2
        here = np.arange(len(square))
        square[here, rows.start + here] = 1  # with themselves: the closed form takes its place
        return d, 1 / np.sqrt(square)

    def matrix(self):
        n = len(self.t)
        A = np.empty((n, 3, n, 3))
        for begin in range(0, n, 250):  # component by component: a temporary array of all is the most of the time
            rows = slice(begin, begin + 250)
            d, inverse = self.far(rows)
            weight = inverse * self.area[rows, None] * self.area
            by_square = weight * inverse**2
            for a in range(3):
                of_a = by_square * d[a]
                for b in range(a, 3):
                    A[rows, b, :, a] = A[rows, a, :, b] = of_a * d[b] + (weight if a == b else 0)
        for i, j, d in self.near():
            inverse = 1 / np.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
            weight = inverse * PAIR_WEIGHTS
            by_square, block = weight * inverse**2, np.empty((len(i), 3, 3))
            for a in range(3):
                of_a = by_square * d[a]
                for b in range(a, 3):
                    block[:, a, b] = block[:, b, a] = np.einsum("nk,nk->n", of_a, d[b]) + (weight.sum(1) if a == b else 0)
            block *= (self.area[i] * self.area[j])[:, None, None]
            A[i, :, j, :] = block
            A[j, :, i, :] = block
        self.own = own(self.edges, self.area)
        t = np.arange(n)
        A[t, :, t, :] = self.own[0]
        # Tractions along the normal (a pressure) move no fluid: A has them as its null vector. The product of the normals fills it.
        A, half = A.reshape(3 * n, 3 * n), self.normal.ravel() / 2
        for begin in range(0, 3 * n, 250):  # in place: a second matrix costs more time than what is written to it
            A[begin:begin + 250] += np.outer(half[begin:begin + 250], half)
            A[begin:begin + 250] /= 8 * np.pi
        return A

    def drag(self):
        b = np.zeros((len(self.t), 3))
        b[:, 0] = self.area
        factor = linalg.cho_factor(self.matrix().T, lower=True, overwrite_a=True, check_finite=False)
        self.f = linalg.cho_solve(factor, b.ravel(), check_finite=False).reshape(-1, 3)
        self.value = float(np.sum(b * self.f))
        return self.value

    def gradient(self):
        """By every vertex, after drag()."""
        n, f, area = len(self.t), self.f, self.area
        q = area[:, None] * f
        by_centroid, by_point = np.zeros((n, 3)), np.zeros((n, 7, 3))
        for begin in range(0, n, 250):
            rows = slice(begin, begin + 250)
            d, inverse = self.far(rows)  # differences with themselves are zero, and pull nothing
            pq = q[rows] @ q.T
            pd, qd = (sum(d[c] * (q[rows, c, None] if own else q[None, :, c]) for c in range(3)) for own in (True, False))
            cubed = inverse**3
            along = -(pq + 3 * pd * qd * inverse**2) * cubed
            for c in range(3):
                by_centroid[rows, c] = 2 * (np.sum(along * d[c], 1) + q[rows, c] * np.sum(qd * cubed, 1) + (pd * cubed) @ q[:, c])
        for i, j, d in self.near():
            far = by_difference(self.centroid[i] - self.centroid[j], q[i], q[j])
            by_centroid += self.summed(j, 2 * far) - self.summed(i, 2 * far)
            inverse = 1 / np.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
            pd, qd = (sum(q[k, c, None] * d[c] for c in range(3)) for k in (i, j))
            cubed = inverse**3 * PAIR_WEIGHTS
            along = -(np.sum(q[i] * q[j], 1)[:, None] + 3 * pd * qd * inverse**2) * cubed
            for c in range(3):
                pull = (along * d[c] + (q[i, c, None] * qd + q[j, c, None] * pd) * cubed).reshape(-1, 7, 7)
                by_point[:, :, c] += self.summed(i, 2 * pull.sum(2)) - self.summed(j, 2 * pull.sum(1))
        block, l, g1, g2, tensor = self.own
        by_edge, by_area = own_gradient(f, self.edges, area, l, g1, g2, tensor)
        # The area stands in both factors of every block; the rows of A f = b say what the others add up to.
        pressure = np.sum(self.normal * f) / 2
        others = 8 * np.pi * f[:, 0] * area - pressure * np.sum(self.normal * f, 1) / 2 - np.einsum("ti,tij,tj->t", f, block, f)
        by_area = by_area + 2 * others / area
        by_area = 2 * f[:, 0] - by_area / (8 * np.pi)
        by_corner = -(by_centroid[:, None] / 3 + np.einsum("pk,tpi->tki", POINTS, by_point)) / (8 * np.pi)
        by_edge = -by_edge / (8 * np.pi)
        for k in range(3):  # edge k runs from corner k + 1 to corner k + 2
            by_corner[:, (k + 2) % 3] += by_edge[:, k]
            by_corner[:, (k + 1) % 3] -= by_edge[:, k]
        # By the area vectors; that of the triangle (a, b, c) changes by half of (edge x da) at every corner.
        by_vector = -2 * pressure * f / (8 * np.pi)
        by_corner += 0.5 * np.cross(by_vector[:, None], self.edges)
        unit = self.normal / np.linalg.norm(self.normal, axis=1, keepdims=True)
        by_corner += 0.5 * by_area[:, None, None] * np.cross(unit[:, None], self.edges)
        sums = np.zeros_like(self.v)
        np.add.at(sums, self.t, by_corner)
        return sums


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        request = json.load(file)
    body = Body(*read_obj(request["surface"]))
    result = {"value": body.drag()}
    if request["wanted"]["gradients"]:
        np.save("gradient.npy", body.gradient())
        result["gradient"] = "gradient.npy"
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        json.dump(result, file)


if __name__ == "__main__":
    main()
