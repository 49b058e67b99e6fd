#!/usr/bin/python3
"""Least induced drag of a wake of any shape (M. Munk, 1921): trefftz.py prints span efficiencies of systems in a box as high as a
fifth of the span.

Far behind, a vortex of strength 1 at p turns the air across: flow at r = (z - z_p, y_p - y) / (2 pi |r - p|^2), in (y, z). Each wing of
the system is a polyline of strips of constant circulation, whose edges shed the steps of it. Drag D = sum G w s / 2 with the flow w
through the strips of length s; lift L = sum G dy. The least D at given L is linear: D = L^2 / (2 dy' A^-1 dy) for D = G' A G / 2, and
e = 2 L^2 / (pi b^2 D).
"""
import math

import numpy as np


def strips(corners, count):
    """Edges of `count` strips along a polyline and places between them. On each straight piece they are finer to both ends, where
    wakes meet or end, equidistant on half a circle; middles are so, too."""
    corners = np.asarray(corners, float)
    edges, middles = [corners[:1]], []
    for a, b in zip(corners, corners[1:]):
        k = (1 - np.cos(np.pi * np.arange(1, count + 1) / count)) / 2
        m = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
        edges.append(a + np.outer(k, b - a))
        middles.append(a + np.outer(m, b - a))
    return np.concatenate(edges), np.concatenate(middles)


def flow_through(edges, middles, at_edges, at):
    """By strips of circulation 1 (columns) through strips (rows), times the lengths of these."""
    along = np.diff(at_edges, axis=0)
    d = at[:, None] - edges[None]
    # Across the strip, from the left of its direction: along x flow.
    by_edge = (along[:, None, 0] * d[..., 0] + along[:, None, 1] * d[..., 1]) / (2 * np.pi * np.sum(d**2, -1))
    return by_edge[:, :-1] - by_edge[:, 1:]


def least(wings, span):
    """Span efficiency of wings whose circulations are free; each is its own polyline [(y, z), ...] of both halves."""
    parts = [(np.asarray(e), np.asarray(m)) for e, m in wings]
    A = np.block([[flow_through(e, m, at_e, at_m) for e, m in parts] for at_e, at_m in parts])
    dy = np.concatenate([np.diff(e[:, 0]) for e, _ in parts])
    return 4 * float(dy @ np.linalg.lstsq(A, dy, rcond=None)[0]) / (math.pi * span**2)


def min_drag_of_half(points, count):
    """Span efficiency of the least drag for a wake along a polyline from the plane of symmetry to the tip, by `count` strips a half."""
    points = np.asarray(points, float)
    places = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    def at(k):
        return np.stack([np.interp(k * places[-1], places, points[:, d]) for d in (0, 1)], 1)
    edges = at(np.sin(np.pi / 2 * np.arange(count + 1) / count))
    middles = at(np.sin(np.pi / 2 * (np.arange(count) + 0.5) / count))
    edges[0, 0] = 0
    both = np.concatenate([edges[:0:-1] * [-1, 1], edges]), np.concatenate([middles[::-1] * [-1, 1], middles])
    return least([both], 2 * points[:, 0].max())


def systems(height=0.2, count=60):
    """Name: efficiency, for a span of 1."""
    h, b = height, 0.5
    def line(*corners):
        return strips(corners, count)
    cut = b * 0.4
    return {
        "plane": least([line((-b, 0), (b, 0))], 1),
        "dihedral": least([line((-b, h), (0, 0), (b, h))], 1),
        "biplane": least([line((-b, 0), (b, 0)), line((-b, h), (b, h))], 1),
        "winglets": least([line((-b, h), (-b, 0), (b, 0), (b, h))], 1),
        "C-wing": least([line((-cut, h), (-b, h), (-b, 0), (b, 0), (b, h), (cut, h))], 1),
        "box": least([line((0, h), (-b, h), (-b, 0), (b, 0), (b, h), (0, h))], 1),
        "tip plates": least([line((-b, 0), (b, 0)), line((-b, -h / 2), (-b, 0), (-b, h / 2)), line((b, -h / 2), (b, 0), (b, h / 2))], 1),
    }


if __name__ == "__main__":
    for name, e in systems().items():
        print(f"{name}: {e:.4f}")
