"""The derivative of a force by the shape, from the flow and its adjoint in the whole domain.

u, p: the flow, of viscosity nu; v, q: its adjoint, v on the body being the direction of the force (times its scale) and zero
elsewhere; sigma = -p I + nu (grad u + grad u^T). Then the force on the body is

    J = - integral of  (u . grad u) . v + sigma : grad v - q div u,

and when the points of the domain move by V, it changes by dJ = - integral of  G_jk d_j V_k  (summed), where

    G_jk = delta_jk (the integrand) - u_j v_i d_k u_i - sigma_ij d_k v_i - nu d_k u_i (d_j v_i + d_i v_j) + q d_k u_j.

The usual form on the wall alone, -nu integral of (du/dn . dv/dn) V_n, is made of slopes at the wall, in which a mesh is
worst; errors of this one go to zero twice as fast (Hiptmair, Paganini, Sargheini, "Comparison of approximate shape
gradients", BIT Numerical Mathematics 55, 2015).
"""
import numpy as np


def by_points(mesh, flow, adjoint, body, wall_adjoint, nu):
    """dJ by all points of the mesh (points x 3), and J. flow, adjoint: u, p and v, q in the cells (cells x 3, cells);
    body: numbers of the body's faces; wall_adjoint: v there. On the rest of the boundary, far away, where nothing moves, the
    values of the cells are taken."""
    (u, p), (v, q) = flow, adjoint
    own = mesh.owner[mesh.inner:]
    du, dv = (mesh.gradient(cells, with_wall(cells[own], body - mesh.inner, wall))
              for cells, wall in ((u, 0), (v, wall_adjoint)))
    one = np.eye(3)
    stress = -p[:, None, None] * one + nu * (du + du.transpose(0, 2, 1))
    integrand = (np.einsum("nj,nji,ni->n", u, du, v) + np.einsum("nij,nji->n", stress, dv) -
                 q * np.einsum("nii->n", du))
    g = (integrand[:, None, None] * one - np.einsum("nj,ni,nki->njk", u, v, du) - np.einsum("nij,nki->njk", stress, dv) -
         nu * np.einsum("nki,nji->njk", du, dv + dv.transpose(0, 2, 1)) + q[:, None, None] * du.transpose(0, 2, 1))
    jump = g[mesh.owner]
    jump[:mesh.inner] -= g[mesh.neighbour]
    by_faces = -np.einsum("nj,njk->nk", mesh.areas, jump) / mesh.count[:, None]
    return scatter(mesh.corners, by_faces[mesh.face_of], len(mesh.points)), -float(mesh.volumes @ integrand)


def with_wall(at_boundary, rows, wall):
    at_boundary[rows] = wall
    return at_boundary


def scatter(rows, values, count):
    """Sums of values (n x 3) by row, count x 3."""
    return np.stack([np.bincount(rows, values[:, k], count) for k in range(3)], axis=1)


class Motion:
    """How the points of the mesh follow those of the body, as displacementLaplacian with uniform stiffness has it: the
    displacement solves the Laplace equation in the cells, and the points inside take weighted means of the cells around
    them. Points on the rest of the boundary rest."""

    def __init__(self, mesh, body):
        m, size = mesh.inner, np.linalg.norm(mesh.areas, axis=1)
        normal = mesh.areas / size[:, None]
        arm = mesh.middles[mesh.neighbour] - mesh.middles[mesh.owner[:m]]
        along = np.maximum(np.einsum("ij,ij->i", arm, normal[:m]), 0.05 * np.linalg.norm(arm, axis=1))
        outward = np.abs(np.einsum("ij,ij->i", mesh.centres[m:] - mesh.middles[mesh.owner[m:]], normal[m:]))
        self.mesh, self.stiffness = mesh, np.concatenate([size[:m] / along, size[m:] / outward])
        self.diagonal = np.bincount(mesh.owner, self.stiffness, mesh.cells)
        self.diagonal += np.bincount(mesh.neighbour, self.stiffness[:m], mesh.cells)
        self.on_body = np.isin(mesh.face_of, body)  # corners
        self.weigh_points()

    def weigh_points(self):
        """Pairs of inner points and cells around them, with weights by inverse distance."""
        mesh = self.mesh
        is_inner = mesh.face_of < mesh.inner
        around = [(mesh.corners, mesh.owner[mesh.face_of]),
                  (mesh.corners[is_inner], mesh.neighbour[mesh.face_of[is_inner]])]
        keys = np.unique(np.concatenate([points * mesh.cells + cells for points, cells in around]))
        outside = np.unique(mesh.corners[~is_inner])
        keys = keys[~np.isin(keys // mesh.cells, outside)]
        self.point, self.cell = keys // mesh.cells, keys % mesh.cells
        weight = 1 / np.linalg.norm(mesh.points[self.point] - mesh.middles[self.cell], axis=1)
        self.weight = weight / np.bincount(self.point, weight, len(mesh.points))[self.point]

    def laplace(self, x):
        mesh, m = self.mesh, self.mesh.inner
        flow = self.stiffness * x[mesh.owner]
        flow[:m] -= self.stiffness[:m] * x[mesh.neighbour]
        return np.bincount(mesh.owner, flow, len(x)) - np.bincount(mesh.neighbour, flow[:m], len(x))

    def solve(self, b):
        """The Laplace equation by conjugate gradients with the diagonal as preconditioner, to eight digits."""
        x, r, limit = np.zeros(len(b)), b.copy(), 1e-8 * np.linalg.norm(b)
        d = z = r / self.diagonal
        for _ in range(10 * len(b)):
            if np.linalg.norm(r) <= limit:
                break
            ad, rz = self.laplace(d), r @ z
            step = rz / (d @ ad)
            x, r = x + step * d, r - step * ad
            z = r / self.diagonal
            d = z + (r @ z) / rz * d
        return x

    def transpose(self, by_points):
        """What has the derivative by_points (points x 3) by all points has this one by those of the body, in the same
        form, when the others follow."""
        mesh, m = self.mesh, self.mesh.inner
        of_cells = scatter(self.cell, self.weight[:, None] * by_points[self.point], mesh.cells)
        moved = np.stack([self.solve(of_cells[:, k]) for k in range(3)], axis=1)
        by_faces = np.zeros((len(mesh.owner), 3))
        by_faces[m:] = self.stiffness[m:, None] * moved[mesh.owner[m:]] / mesh.count[m:, None]
        corners = mesh.corners[self.on_body]
        out = scatter(corners, by_faces[mesh.face_of[self.on_body]], len(mesh.points))
        own = np.unique(corners)
        out[own] += by_points[own]
        return out
