"""Points that move with a boundary: nipples and markers, held by the face of the mesh that they lie on."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.mesh import SUBTRIANGLES, TetMesh
from mammosim.mechanics.reference import TRIANGLE, shape_functions, shape_gradients
from mammosim.meshing.distance import NearestOnTriangles

# Barycentric coordinates (6, 3) of the nodes of a quadratic triangle.
NODES = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])
PIECES = np.array(SUBTRIANGLES)


@dataclass(frozen=True)
class MaterialPoints:
    """Points of the skin: the face (n,) that carries each, its nodes (n, 6), weights (n, 6), offset_mm (n,).

    weights: values of the face's shape functions, N_a; offset_mm: how far the point given was from the skin.
    """

    face: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    offset_mm: np.ndarray

    @classmethod
    def on(cls, mesh: TetMesh, points: np.ndarray, *, boundary: str = "skin") -> "MaterialPoints":
        """The nearest points of a boundary of `mesh` to points (n, 3) mm, both in the mesh's frame.

        Raises MeshError when the mesh lacks the boundary.
        """
        if boundary not in mesh.boundaries or len(mesh.boundaries[boundary]) == 0:
            raise MeshError(
                f"the mesh has no boundary {boundary!r}; it has: {', '.join(mesh.boundaries) or 'none'}"
            )
        faces, points = mesh.boundaries[boundary], np.reshape(points, (-1, 3))
        corners = mesh.points[faces[:, SUBTRIANGLES].reshape(-1, 3)]
        nearest, triangle = NearestOnTriangles(corners)(points)
        L = np.einsum("nc,ncd->nd", _barycentric(nearest, corners[triangle]), NODES[PIECES[triangle % 4]])
        offset = np.linalg.norm(nearest - points, axis=1)
        return cls(triangle // 4, faces[triangle // 4], shape_functions(L, TRIANGLE), offset)

    def carry(self, points: np.ndarray) -> np.ndarray:
        """Where they are, (n, 3), when the nodes of the mesh are at points (n_node, 3): x = sum_a N_a x_a."""
        found: np.ndarray = np.einsum("na,nad->nd", self.weights, points[self.nodes])
        return found

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Unit normals (n, 3) of their faces there, outward, when the nodes are at points (n_node, 3)."""
        L = self.weights @ NODES  # shape functions reproduce linear fields
        along, across = np.einsum("nak,nad->knd", shape_gradients(L, TRIANGLE), points[self.nodes])
        normal = np.cross(along, across)
        found: np.ndarray = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        return found

    def carry_above(self, given: np.ndarray, points: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Where balls with centres `given` (n, 3) are, (n, 3), each as high above the skin as it was.

        points, new: (n_node, 3) of the nodes, where the balls were given and now; x + h n, h = (p - x0) . n0.
        """
        h = np.einsum("nd,nd->n", given - self.carry(points), self.normals(points))
        found: np.ndarray = self.carry(new) + h[:, None] * self.normals(new)
        return found


def _barycentric(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Coordinates (n, 3) of points (n, 3) in the planes of triangles (n, 3, 3); (1, 0, 0) if degenerate."""
    u, v, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    uu, uv, vv, uw, vw = (np.einsum("nd,nd->n", *p) for p in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    D = np.maximum(uu * vv - uv**2, np.finfo(float).tiny)
    s, t = (vv * uw - uv * vw) / D, (uu * vw - uv * uw) / D
    return np.stack([1 - s - t, s, t], axis=1)
