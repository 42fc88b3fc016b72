"""The nearest point of a triangle surface, and how far the skin of one mesh lies from that of another."""

import numpy as np
from scipy.spatial import cKDTree
from skfem.element import ElementLineP2, ElementTriP2

from mammosim.core.errors import MeshError
from mammosim.core.mesh import TetMesh
from mammosim.io.compiled import njit
from mammosim.meshing.lattice import dot

# Of triangles whose squared distances differ by less than this factor the first counts as the nearest, so
# that the last bit does not choose between two that are equally far.
NEARER = 1 - 1e-12


class NearestOnTriangles:
    """Exact nearest points on triangles with corners (m, 3, 3) mm."""

    def __init__(self, corners: np.ndarray) -> None:
        self.corners = np.ascontiguousarray(corners, dtype=float)
        centres = self.corners.mean(axis=1)
        self._radius = np.linalg.norm(self.corners - centres[:, None], axis=2).max()
        self._tree = cKDTree(centres)

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearest point (n, 3) on any triangle and the number (n,) of that triangle, for points (n, 3)."""
        points = np.ascontiguousarray(points, dtype=float)
        _, first = self._tree.query(points)
        start = np.arange(len(points) + 1)
        bound = np.linalg.norm(_nearest(points, self.corners, start, first)[0] - points, axis=1)
        # A triangle that comes nearer has its centre within the bound plus the largest circumradius.
        near = self._tree.query_ball_point(points, bound + self._radius * (1 + 1e-9), return_sorted=True)
        start = np.concatenate([[0], np.cumsum([len(n) for n in near])])
        return _nearest(points, self.corners, start, np.concatenate(near).astype(np.int64))


@njit(cache=True)
def _nearest(
    points: np.ndarray, corners: np.ndarray, start: np.ndarray, candidates: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    nearest = np.empty_like(points)
    which = np.empty(len(points), dtype=np.int64)
    for n in range(len(points)):
        smallest = np.inf
        for c in range(start[n], start[n + 1]):
            t = candidates[c]
            q = _nearest_on_triangle(points[n], corners[t, 0], corners[t, 1], corners[t, 2])
            d = np.sum((q - points[n]) ** 2)
            if d < smallest * NEARER:
                smallest = d
                nearest[n] = q
                which[n] = t
    return nearest, which


@njit(cache=True)
def _nearest_on_triangle(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """By the Voronoi region of p: corners, then edges, then the face (Ericson 2005, section 5.1.5)."""
    ab, ac, ap, bp, cp = b - a, c - a, p - a, p - b, p - c
    d1, d2 = dot(ab, ap), dot(ac, ap)
    d3, d4 = dot(ab, bp), dot(ac, bp)
    d5, d6 = dot(ab, cp), dot(ac, cp)
    if d1 <= 0 and d2 <= 0:
        return a
    if d3 >= 0 and d4 <= d3:
        return b
    if d6 >= 0 and d5 <= d6:
        return c
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        return a + ab * (d1 / (d1 - d3))
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        return a + ac * (d2 / (d2 - d6))
    if va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    return a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))


TRIANGLE, EDGE = ElementTriP2(), ElementLineP2()
# Flat pieces along an edge of a quadratic face: of its sagitta 1/16 is left as an error.
PIECES = 4
# A nearest point this near to the rim lies on it: rounding of coordinates of some 100 mm, with a margin.
ON_RIM_MM = 1e-6
# Corners and mid-edge nodes of the edges of a quadratic triangle.
FACE_EDGES = ((0, 1, 3), (1, 2, 4), (2, 0, 5))


def surface_distance(mesh: TetMesh, other: TetMesh, *, boundary: str = "skin") -> np.ndarray:
    """Distance (n,) mm from each node of a mesh's boundary, numbers ascending, to the other's boundary.

    Raises MeshError when one of them has no such boundary.
    """
    require_boundary(mesh, boundary)
    return distance_to_boundary(mesh.points[mesh.boundary_nodes(boundary)], other, boundary=boundary)


def distance_to_boundary(points: np.ndarray, mesh: TetMesh, *, boundary: str = "skin") -> np.ndarray:
    """Distance (n,) mm from points (n, 3) to the quadratic faces of a boundary.

    Raises MeshError when the mesh has no such boundary.
    """
    require_boundary(mesh, boundary)
    nearest, _ = NearestOnTriangles(flat_pieces(mesh.points[mesh.boundaries[boundary]]))(points)
    return np.linalg.norm(nearest - points, axis=1)


def distance_opposite(mesh: TetMesh, other: TetMesh, *, boundary: str = "skin") -> np.ndarray:
    """surface_distance, NaN where the other's nearest point lies on the rim of its boundary.

    There the other's boundary ends, and a distance would say where it was cut, not where it lies.
    Raises MeshError when one of them has no such boundary.
    """
    require_boundary(mesh, boundary)
    require_boundary(other, boundary)
    points, faces = mesh.points[mesh.boundary_nodes(boundary)], other.boundaries[boundary]
    nearest, _ = NearestOnTriangles(flat_pieces(other.points[faces]))(points)
    distance = np.linalg.norm(nearest - points, axis=1)
    distance[_to_edges(nearest, other.points[rim(faces)]) < ON_RIM_MM] = np.nan
    return distance


def distance_to_rim(mesh: TetMesh, *, boundary: str = "skin") -> np.ndarray:
    """Distance (n,) mm from each node of a boundary, numbers ascending, to where it ends; inf when closed.

    Raises MeshError when the mesh has no such boundary.
    """
    require_boundary(mesh, boundary)
    edges = mesh.points[rim(mesh.boundaries[boundary])]
    return _to_edges(mesh.points[mesh.boundary_nodes(boundary)], edges)


def rim(faces: np.ndarray) -> np.ndarray:
    """Edges (n, 3), two corners and the node between, that belong to one of the faces (n_face, 6) only."""
    edges = faces[:, FACE_EDGES].reshape(-1, 3)
    _, first, count = np.unique(np.sort(edges[:, :2], axis=1), axis=0, return_index=True, return_counts=True)
    return edges[first[count == 1]]


def _to_edges(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Distance (n,) mm from points (n, 3) to quadratic edges (m, 3, 3), taken as straight pieces."""
    if len(edges) == 0:
        return np.full(len(points), np.inf)
    s = np.linspace(0, 1, PIECES + 1)
    N = [EDGE.lbasis(s[None], a)[0] for a in range(3)]
    ends = np.array([(i, i + 1, i + 1) for i in range(PIECES)])
    pieces = np.einsum("aq,fad->fqd", N, edges)[:, ends].reshape(-1, 3, 3)
    nearest, _ = NearestOnTriangles(pieces)(points)
    return np.linalg.norm(nearest - points, axis=1)


def require_boundary(mesh: TetMesh, name: str) -> None:
    """Raise MeshError unless the mesh has faces of that boundary."""
    if not len(mesh.boundaries.get(name, ())):
        raise MeshError(f"the mesh has no boundary {name!r}; it has: {', '.join(mesh.boundaries) or 'none'}")


def flat_pieces(faces: np.ndarray) -> np.ndarray:
    """Flat triangles (n_face * PIECES^2, 3, 3), their corners on quadratic faces (n_face, 6, 3)."""
    k = PIECES
    at = {(i, j): n for n, (i, j) in enumerate((i, j) for i in range(k + 1) for j in range(k + 1 - i))}
    upward = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in at if i + j < k]
    downward = [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in at if i + j < k - 1]
    i, j = np.array(list(at)).T / k
    points = np.einsum("aq,fad->fqd", [TRIANGLE.lbasis((i, j), a)[0] for a in range(6)], faces)
    return points[:, np.array(upward + downward)].reshape(-1, 3, 3)
