"""How far the skin of one mesh lies from the skin of another."""

import numpy as np
from skfem.element import ElementLineP2, ElementTriP2

from mammosim.core.errors import MeshError
from mammosim.core.mesh import TetMesh
from mammosim.meshing.nearest import NearestOnTriangles

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
