"""Points that move with the skin: nipples and markers, held by the face of the mesh that they lie on."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.mesh import SUBTRIANGLES, TetMesh

# Barycentric coordinates (6, 3) of the nodes of a quadratic triangle.
NODES = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])


@dataclass(frozen=True)
class MaterialPoints:
    """Points of the skin: nodes (n, 6) of the face that carries each, weights (n, 6), offset_mm (n,).

    weights: values of the face's shape functions, N_a; offset_mm: how far the point given was from the skin.
    """

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
        faces = mesh.boundaries[boundary]
        corners = mesh.points[faces[:, SUBTRIANGLES].reshape(-1, 3)]
        nearest = [_nearest(point, corners) for point in np.reshape(points, (-1, 3))]
        triangle, b, offset = map(np.array, zip(*nearest))
        L = np.einsum("nc,ncd->nd", b, NODES[np.array(SUBTRIANGLES)[triangle % 4]])
        return cls(faces[triangle // 4], shape_functions(L), offset)

    def carry(self, points: np.ndarray) -> np.ndarray:
        """Where they are, (n, 3), when the nodes of the mesh are at points (n_node, 3): x = sum_a N_a x_a."""
        return np.einsum("na,nad->nd", self.weights, points[self.nodes])

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Unit normals (n, 3) of their faces there, outward, when the nodes are at points (n_node, 3)."""
        L = self.weights @ NODES  # shape functions reproduce linear fields
        slopes = shape_slopes(L)
        x = points[self.nodes]
        along, across = (np.einsum("na,nad->nd", slopes[:, k] - slopes[:, 0], x) for k in (1, 2))
        normal = np.cross(along, across)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def carry_above(self, given: np.ndarray, points: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Where balls with centres `given` (n, 3) are, (n, 3), each as high above the skin as it was.

        points, new: (n_node, 3) of the nodes, where the balls were given and now; x + h n, h = (p - x0) . n0.
        """
        h = np.einsum("nd,nd->n", given - self.carry(points), self.normals(points))
        return self.carry(new) + h[:, None] * self.normals(new)


def shape_slopes(L: np.ndarray) -> np.ndarray:
    """dN_a / dL_k (n, 3, 6) of shape_functions at L (n, 3), its three coordinates taken as independent."""
    slopes = np.zeros((len(L), 3, 6))
    for k in range(3):
        after = (k + 1) % 3
        slopes[:, k, k] = 4 * L[:, k] - 1
        slopes[:, k, 3 + k] = 4 * L[:, after]
        slopes[:, after, 3 + k] = 4 * L[:, k]
    return slopes


def shape_functions(L: np.ndarray) -> np.ndarray:
    """N (n, 6) of the quadratic triangle at barycentric coordinates L (n, 3), nodes in VTK order."""
    corners = L * (2 * L - 1)
    edges = 4 * L * np.roll(L, -1, axis=1)
    return np.hstack([corners, edges])


def _nearest(point: np.ndarray, corners: np.ndarray) -> tuple[int, np.ndarray, float]:
    """Number of the nearest of triangles (n, 3, 3), barycentric coordinates (3,) there, and distance, mm."""
    b = np.concatenate([_inside(point, corners)[None], *(_edge(point, corners, k)[None] for k in range(3))])
    distance = np.linalg.norm(np.einsum("knc,ncd->knd", b, corners) - point, axis=2)
    distance[np.min(b, axis=2) < 0] = np.inf
    kind, triangle = np.unravel_index(np.argmin(distance), distance.shape)
    return int(triangle), b[kind, triangle], float(distance[kind, triangle])


def _inside(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Barycentric coordinates (n, 3) of the projection onto each plane; negative outside the triangle."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    w = point - a
    uu, uv, vv = (np.einsum("nd,nd->n", *pair) for pair in ((u, u), (u, v), (v, v)))
    uw, vw = np.einsum("nd,nd->n", u, w), np.einsum("nd,nd->n", v, w)
    D = np.maximum(uu * vv - uv**2, np.finfo(float).tiny)
    s, t = (vv * uw - uv * vw) / D, (uu * vw - uv * uw) / D
    return np.stack([1 - s - t, s, t], axis=1)


def _edge(point: np.ndarray, corners: np.ndarray, k: int) -> np.ndarray:
    """Barycentric coordinates (n, 3) of the nearest point of edge k of each triangle."""
    a, b = corners[:, k], corners[:, (k + 1) % 3]
    length2 = np.maximum(np.einsum("nd,nd->n", b - a, b - a), np.finfo(float).tiny)
    s = np.clip(np.einsum("nd,nd->n", b - a, point - a) / length2, 0, 1)
    weights = np.zeros((len(corners), 3))
    weights[:, k], weights[:, (k + 1) % 3] = 1 - s, s
    return weights
