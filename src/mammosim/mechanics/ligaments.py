"""Where Cooper's ligaments run: from the deep fascia, in front of the muscle or the chest wall, to the skin.

They follow the gradient of phi with Laplace phi = 0, phi = 0 on the deep faces and 1 on the skin: smooth, at
right angles to both, and unbranched. In linear tetrahedra, those of scikit-fem, grad phi is constant.
"""

# ASSUME: Cooper's ligaments run from the deep fascia to the skin along the gradient of a harmonic function.
# ASSUME: ligaments of a spring network join points spread over the skin to the nearest deep points.

import numpy as np
from scipy.spatial import cKDTree
from skfem import Basis, ElementTetP1, MeshTet, condense, solve
from skfem.models.poisson import laplace
from skfem.refdom import RefTet

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import FACES, TetMesh
from mammosim.mechanics.reference import faces_of

_FACET = [RefTet.facets.index(sorted(face[:3])) for face in FACES]  # scikit-fem's number of each of FACES


def faces_between(mesh: TetMesh, tissue: Label) -> np.ndarray:
    """Faces (n_face, 6) that a cell of a tissue shares with a cell of another, normals out of the tissue.

    As a boundary of the mesh they can carry a fascia; there are none where the mesh lacks the tissue.
    """
    straight = _straight(mesh.points, mesh.cells[:, :4])
    one, other = straight.f2t
    inside = mesh.tissue == tissue
    border = (other >= 0) & (inside[one] != inside[other])
    between: np.ndarray = mesh.cells[:, FACES][border[straight.t2f[_FACET].T] & inside[:, None]]
    return between


def deep_faces(mesh: TetMesh) -> np.ndarray:
    """Where ligaments begin (n_face, 6): on the muscle, and on `posterior` where there is no muscle.

    Raises MechanicsError when the mesh has no boundary `posterior`.
    """
    muscle = np.unique(mesh.cells[mesh.tissue == Label.MUSCLE])
    posterior = faces_of(mesh, "posterior")
    free = ~np.isin(posterior, muscle).all(axis=1)
    return np.vstack([faces_between(mesh, Label.MUSCLE), posterior[free]])


def ligament_directions(mesh: TetMesh) -> np.ndarray:
    """Unit vectors (n_cell, 3) towards the skin: directions for Fibres.

    Zero in muscle, and in cells with all vertices on the skin, where phi does not change. mesh.points are the
    reference. Raises MechanicsError without the boundaries `skin` and `posterior`.
    """
    muscle = mesh.tissue == Label.MUSCLE
    gradient = np.zeros((len(mesh.cells), 3))
    gradient[~muscle] = _harmonic_slopes(
        mesh.points, mesh.cells[~muscle, :4], deep_faces(mesh)[:, :3], faces_of(mesh, "skin")[:, :3]
    )
    lengths = np.linalg.norm(gradient, axis=1, keepdims=True)
    a: np.ndarray = np.divide(gradient, lengths, out=np.zeros_like(gradient), where=lengths > 0)
    return a


def _harmonic_slopes(points: np.ndarray, cells: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """grad phi (n_cell, 3) of linear tetrahedra (n_cell, 4), phi 0 at the nodes `low`, 1 at other `high`."""
    nodes, number = np.unique(cells, return_inverse=True)
    basis = Basis(_straight(points[nodes], number.reshape(-1, 4)), ElementTetP1(), intorder=1)
    at_low, at_high = np.isin(nodes, low), np.isin(nodes, high)
    given = np.where(at_high & ~at_low, 1.0, 0.0)
    phi = solve(*condense(laplace.assemble(basis), x=given, D=np.flatnonzero(at_low | at_high)))
    gradient: np.ndarray = basis.interpolate(phi).grad[:, :, 0].T
    gradient[np.ptp(phi[number.reshape(-1, 4)], axis=1) == 0] = 0.0  # rounding has no direction
    return gradient


def _straight(points: np.ndarray, tetrahedra: np.ndarray) -> MeshTet:
    """Points (n, 3) and tetrahedra (n_cell, 4) in the layout of scikit-fem."""
    return MeshTet(np.ascontiguousarray(points.T), np.ascontiguousarray(tetrahedra.T))


def ligament_pairs(mesh: TetMesh, *, spacing_mm: float) -> np.ndarray:
    """Pairs (n_spring, 2) of a vertex of the skin and the nearest deep vertex: ends for Springs.

    Vertices of the skin are taken in the order of their numbers, none nearer than spacing_mm to another.
    mesh.points are the reference. Raises MechanicsError for a spacing that is not above 0, or without the
    boundaries `skin` and `posterior`.
    """
    if spacing_mm <= 0:
        raise MechanicsError(f"spacing_mm = {spacing_mm:g} of the ligaments must be above 0; try 10")
    deep = np.unique(deep_faces(mesh)[:, :3])
    skin = np.setdiff1d(faces_of(mesh, "skin")[:, :3], deep)
    near = cKDTree(mesh.points[skin])
    taken = np.zeros(len(skin), dtype=bool)
    shadowed = np.zeros(len(skin), dtype=bool)
    for vertex, point in enumerate(mesh.points[skin]):
        if not shadowed[vertex]:
            taken[vertex] = True
            shadowed[near.query_ball_point(point, spacing_mm)] = True
    ends = skin[taken]
    nearest = cKDTree(mesh.points[deep]).query(mesh.points[ends])[1]
    return np.stack([deep[nearest], ends], axis=1)
