"""Problems that are rejected before anything is assembled."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.reference import smallest_jacobians

# A cell flatter than this, relative to the cube of its longest edge, has lost all digits of its gradients.
SMALLEST_RELATIVE_VOLUME = 1e-6


def require_well_posed(mesh: TetMesh, held: np.ndarray | None) -> np.ndarray:
    """held (n_node, 3) bool, when the mesh can be solved; None where it has no boundary 'posterior'.

    Raises MechanicsError, naming cells or nodes and how many.
    """
    if held is None:
        names = ", ".join(sorted(mesh.boundaries)) or "none"
        raise MechanicsError(f"the mesh has no boundary 'posterior' (it has: {names}), so nothing is held")
    if not held.any():
        raise MechanicsError("the boundary 'posterior' is empty: nothing is held")
    _require_finite(mesh)
    _require_positive_cells(mesh)
    _require_attached(mesh, np.any(held, axis=1))
    return held


def faces_of(mesh: TetMesh, boundary: str) -> np.ndarray:
    """The faces (n_face, 6) of a named boundary. Raises MechanicsError when the mesh has none."""
    if boundary not in mesh.boundaries:
        names = ", ".join(sorted(mesh.boundaries)) or "none"
        raise MechanicsError(f"the mesh has no boundary {boundary!r}; it has: {names}")
    return mesh.boundaries[boundary]


def _require_finite(mesh: TetMesh) -> None:
    bad = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if len(bad):
        raise MechanicsError(f"{len(bad)} nodes have coordinates that are no numbers: {_listed(bad)}")


def _require_positive_cells(mesh: TetMesh) -> None:
    smallest = smallest_jacobians(mesh.points, mesh.cells)
    corners = mesh.points[mesh.cells[:, :4]]
    edges = corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]]
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    bad = np.flatnonzero(smallest <= SMALLEST_RELATIVE_VOLUME * longest**3)
    if len(bad):
        raise MechanicsError(
            f"{len(bad)} cells are inverted or flat (det dX/dxi down to {smallest.min():.3g} mm3): "
            f"{_listed(bad)}; re-mesh, or move their mid-edge nodes to the middle"
        )


def _require_attached(mesh: TetMesh, held: np.ndarray) -> None:
    n_node = len(mesh.points)
    used = np.zeros(n_node, dtype=bool)
    used[mesh.cells] = True
    if not used.all():
        loose = np.flatnonzero(~used)
        raise MechanicsError(f"{len(loose)} nodes belong to no cell: {_listed(loose)}; remove them")
    first = np.repeat(mesh.cells[:, 0], 10)
    links = sparse.coo_matrix((np.ones(first.size), (first, mesh.cells.ravel())), (n_node, n_node))
    count, piece = connected_components(links, directed=False)
    floating = np.setdiff1d(np.arange(count), piece[held])
    if len(floating):
        cells = np.flatnonzero(np.isin(piece[mesh.cells[:, 0]], floating))
        raise MechanicsError(
            f"{len(floating)} pieces of the mesh ({len(cells)} cells: {_listed(cells)}) are not attached to "
            "'posterior'; remove them, or connect them"
        )


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(map(str, numbers[:5])) + (", ..." if len(numbers) > 5 else "")
