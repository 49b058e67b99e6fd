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


def stokeslets(d):
    """1/r and d/r for differences d (... x 3)."""
    inverse = 1 / np.sqrt(np.sum(d**2, -1))
    return inverse, d * inverse[..., None]


def by_difference(d, p, q):
    """Derivative of p.G(d) q by d."""
    inverse, e = stokeslets(d)
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
        """Differences between the points of near pairs, pair by pair: pairs x 7 x 7 x 3, in pieces."""
        for begin in range(0, len(self.i), 20000):
            i, j = self.i[begin:begin + 20000], self.j[begin:begin + 20000]
            yield i, j, self.points[i][:, :, None] - self.points[j][:, None, :]

    def matrix(self):
        n = len(self.t)
        A = np.empty((n, 3, n, 3))
        for begin in range(0, n, 250):
            d = self.centroid[begin:begin + 250, None] - self.centroid[None]
            here = np.arange(len(d))
            d[here, begin + here] = 1
            inverse, e = stokeslets(d)
            weight = inverse * self.area[begin:begin + 250, None] * self.area
            A[begin:begin + 250] = (np.einsum("ij,ab->iajb", weight, np.eye(3))
                                    + (weight[..., None, None] * e[..., :, None] * e[..., None, :]).transpose(0, 2, 1, 3))
        for i, j, d in self.near():
            inverse, e = stokeslets(d)
            weight = inverse * WEIGHTS[:, None] * WEIGHTS
            block = np.einsum("npq,npqa,npqb->nab", weight, e, e, optimize=True) + weight.sum((1, 2))[:, None, None] * np.eye(3)
            block *= (self.area[i] * self.area[j])[:, None, None]
            A[i, :, j, :] = block
            A[j, :, i, :] = block
        self.own = own(self.edges, self.area)
        t = np.arange(n)
        A[t, :, t, :] = self.own[0]
        # Tractions along the normal (a pressure) move no fluid: A has them as its null vector. The product of the normals fills it.
        A = A.reshape(3 * n, 3 * n)
        A += np.outer(self.normal.ravel() / 2, self.normal.ravel() / 2)
        return A / (8 * np.pi)

    def drag(self):
        b = np.zeros((len(self.t), 3))
        b[:, 0] = self.area
        self.f = linalg.solve(self.matrix(), b.ravel(), assume_a="pos", overwrite_a=True, check_finite=False).reshape(-1, 3)
        self.value = float(np.sum(b * self.f))
        return self.value

    def gradient(self):
        """By every vertex, after drag()."""
        n, f, area = len(self.t), self.f, self.area
        q = area[:, None] * f
        by_centroid, by_point = np.zeros((n, 3)), np.zeros((n, 7, 3))
        for begin in range(0, n, 250):
            d = self.centroid[begin:begin + 250, None] - self.centroid[None]
            here = np.arange(len(d))
            d[here, begin + here] = 1
            pull = by_difference(d, q[begin:begin + 250, None], q[None])
            pull[here, begin + here] = 0
            by_centroid[begin:begin + 250] = 2 * pull.sum(1)
        for i, j, d in self.near():
            far = by_difference(self.centroid[i] - self.centroid[j], q[i], q[j])
            np.add.at(by_centroid, i, -2 * far)
            np.add.at(by_centroid, j, 2 * far)
            pull = by_difference(d, q[i][:, None, None], q[j][:, None, None]) * (WEIGHTS[:, None] * WEIGHTS)[..., None]
            np.add.at(by_point, i, 2 * pull.sum(2))
            np.add.at(by_point, j, -2 * pull.sum(1))
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
