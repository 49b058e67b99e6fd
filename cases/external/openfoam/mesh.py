"""A finite-volume mesh: faces and cells of a polyMesh folder, their geometry and gradients as OpenFOAM has them."""
import os
import re

import numpy as np

import foam


class Mesh:
    """Points (n x 3); faces as lists of point numbers one after another in `corners`, face f from first[f] to first[f + 1];
    `owner` of each face, `neighbour` of the `inner` ones, which come first."""

    def __init__(self, points, faces, owner, neighbour):
        self.points, self.owner, self.neighbour = points, owner, neighbour
        self.count = np.array([len(face) for face in faces])
        self.first = np.concatenate([[0], np.cumsum(self.count)])
        self.corners = np.concatenate(faces)
        self.face_of = np.repeat(np.arange(len(faces)), self.count)
        self.inner, self.cells = len(neighbour), int(max(owner.max(), neighbour.max(initial=0))) + 1
        self.measure()

    @classmethod
    def read(cls, folder):
        faces = re.findall(rb"\d+\(([^)]*)\)", foam.body_of(os.path.join(folder, "faces")))
        labels = [foam.numbers(foam.body_of(os.path.join(folder, name)))[1:].astype(int) for name in ("owner", "neighbour")]
        if len(labels[0]) != len(faces) or len(labels[1]) >= len(faces):
            foam.fail(f"{folder}: {len(faces)} faces, {len(labels[0])} owners and {len(labels[1])} neighbours")
        return cls(foam.read_points(folder), [np.array(face.split(), dtype=int) for face in faces], *labels)

    def following(self):
        """For each corner, where the next one of its face stands."""
        rows = np.arange(1, len(self.corners) + 1)
        rows[self.first[1:] - 1] = self.first[:-1]
        return rows

    def over_faces(self, at_corners):
        """Sums over the corners of each face."""
        return np.add.reduceat(at_corners, self.first[:-1], axis=0)

    def over_cells(self, of_owner, of_neighbour):
        """Sums over the faces of each cell; rows of the first for all faces, of the second for the inner ones."""
        flat, other = of_owner.reshape(len(of_owner), -1), of_neighbour.reshape(len(of_neighbour), -1)
        out = np.empty((self.cells, flat.shape[1]))
        for k in range(flat.shape[1]):
            out[:, k] = (np.bincount(self.owner, flat[:, k], self.cells) +
                         np.bincount(self.neighbour, other[:, k], self.cells))
        return out.reshape((self.cells,) + of_owner.shape[1:])

    def measure(self):
        """areas (vectors out of the owner) and centres of the faces, volumes and middles of the cells."""
        at, m = self.points[self.corners], self.inner
        after, middle = at[self.following()], (self.over_faces(at) / self.count[:, None])[self.face_of]
        normal = 0.5 * np.cross(after - at, middle - at)
        size = np.linalg.norm(normal, axis=1)[:, None]
        self.areas = self.over_faces(normal)
        self.centres = self.over_faces(size * (at + after + middle) / 3) / self.over_faces(size)
        ones = np.ones((len(self.owner), 1))
        guess = self.over_cells(self.centres, self.centres[:m]) / self.over_cells(ones, ones[:m])
        near = np.einsum("ij,ij->i", self.areas, self.centres - guess[self.owner])[:, None]
        far = np.einsum("ij,ij->i", self.areas[:m], guess[self.neighbour] - self.centres[:m])[:, None]
        total = self.over_cells(near, far)  # three times the volume, of pyramids above the faces
        self.middles = self.over_cells(near * (0.75 * self.centres + 0.25 * guess[self.owner]),
                                       far * (0.75 * self.centres[:m] + 0.25 * guess[self.neighbour])) / total
        self.volumes = total[:, 0] / 3

    def gradient(self, at_cells, at_boundary):
        """Gauss, linear: d_j of each component, cells x 3 x components; at_boundary: the values on the outer faces."""
        m, normal = self.inner, self.areas[:self.inner]
        near = np.abs(np.einsum("ij,ij->i", normal, self.centres[:m] - self.middles[self.owner[:m]]))
        far = np.abs(np.einsum("ij,ij->i", normal, self.middles[self.neighbour] - self.centres[:m]))
        weight = (far / (near + far))[:, None]
        at_faces = np.empty((len(self.owner), at_cells.shape[1]))
        at_faces[:m] = weight * at_cells[self.owner[:m]] + (1 - weight) * at_cells[self.neighbour]
        at_faces[m:] = at_boundary
        flow = self.areas[:, :, None] * at_faces[:, None, :]
        return self.over_cells(flow, -flow[:m]) / self.volumes[:, None, None]
