"""Where Cooper's ligaments run: from the deep fascia, in front of the muscle or the chest wall, to the skin.

They follow the gradient of phi with Laplace phi = 0, phi = 0 on the deep faces and 1 on the skin: smooth, at
right angles to both, and unbranched. In linear tetrahedra it is constant:

    grad phi = sum_a phi_a grad N_a,  grad N_a: column a of [1 X]^(-1),  K_ab = V grad N_a . grad N_b
"""

# ASSUME: Cooper's ligaments run from the deep fascia to the skin along the gradient of a harmonic function.
# ASSUME: ligaments of a spring network join points spread over the skin to the nearest deep points.

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import FACES, TetMesh
from mammosim.mechanics.soundness import faces_of


def faces_between(mesh: TetMesh, tissue: Label) -> np.ndarray:
    """Faces (n_face, 6) that a cell of a tissue shares with a cell of another, normals out of the tissue.

    As a boundary of the mesh they can carry a fascia; there are none where the mesh lacks the tissue.
    """
    faces = mesh.cells[:, FACES].reshape(-1, 6)
    inside = np.repeat(mesh.tissue == tissue, len(FACES))
    _, number, count = np.unique(
        np.sort(faces[:, :3], axis=1), axis=0, return_inverse=True, return_counts=True
    )
    of_tissue = np.bincount(number.ravel()[inside], minlength=len(count))
    between: np.ndarray = faces[inside & ((of_tissue == 1) & (count == 2))[number.ravel()]]
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
    """Unit vectors (n_cell, 3) towards the skin, zero in muscle: directions for Fibres.

    mesh.points are the reference. Raises MechanicsError without the boundaries `skin` and `posterior`.
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
    number = number.reshape(-1, 4)
    with_one = np.concatenate([np.ones((len(cells), 4, 1)), points[cells]], axis=2)
    slopes = np.linalg.inv(with_one)[:, 1:, :]  # grad N_a (n_cell, 3, 4)
    volumes = np.abs(np.linalg.det(with_one)) / 6
    Ke = volumes[:, None, None] * np.einsum("eia,eib->eab", slopes, slopes)
    rows, columns = np.repeat(number, 4, axis=1).ravel(), np.tile(number, (1, 4)).ravel()
    K = sparse.csr_matrix((Ke.ravel(), (rows, columns)), shape=(len(nodes), len(nodes)))
    at_low, at_high = np.isin(nodes, low), np.isin(nodes, high)
    free = ~at_low & ~at_high
    phi = np.where(at_high & ~at_low, 1.0, 0.0)
    phi[free] = spsolve(K[free][:, free].tocsc(), -K[free][:, ~free] @ phi[~free])
    gradient: np.ndarray = np.einsum("eia,ea->ei", slopes, phi[number])
    return gradient


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
