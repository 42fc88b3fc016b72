"""Tetrahedral meshes, in mm, in the patient frame LPS."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mammosim.core.labels import Label

# VTK order of the quadratic tetrahedron: vertices 0-3, then the mid-edge nodes of these edges.
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
# Faces of a tetrahedron with outward normals, as vertices and then mid-edge nodes (VTK quadratic triangle).
FACES = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (0, 3, 2, 7, 9, 6))
# The eight linear tetrahedra of a quadratic one, as local node numbers.
SUBTETRAHEDRA = (
    (0, 4, 6, 7),
    (4, 1, 5, 8),
    (6, 5, 2, 9),
    (7, 8, 9, 3),
    (4, 5, 6, 8),
    (4, 6, 7, 8),
    (6, 5, 9, 8),
    (6, 9, 7, 8),
)
# The four linear triangles of a quadratic one, as local node numbers.
SUBTRIANGLES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


@dataclass(frozen=True)
class TetMesh:
    """Quadratic tetrahedra.

    points: (n_node, 3) mm.
    cells: (n_cell, 10) node numbers in VTK order.
    tissue: (n_cell,) core.labels.Label of each cell: that of most of its volume.
    shares: (n_cell, len(Label)) of each cell's volume that each label has; None: cells wholly of one tissue.
    boundaries: name -> (n_face, 6) node numbers of quadratic triangles, normals outward;
        'skin' meets the air, 'posterior' is where the tissue is held.
    """

    points: np.ndarray
    cells: np.ndarray
    tissue: np.ndarray
    boundaries: Mapping[str, np.ndarray] = field(default_factory=dict)
    shares: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise ValueError(f"points {self.points.shape} must be (n_node, 3)")
        if self.cells.ndim != 2 or self.cells.shape[1] != 10:
            raise ValueError(f"cells {self.cells.shape} must be (n_cell, 10): quadratic tetrahedra")
        if self.tissue.shape != (len(self.cells),):
            raise ValueError(f"tissue {self.tissue.shape} must be (n_cell,) = ({len(self.cells)},)")
        if self.shares is not None:
            self._require_shares(self.shares)

    def _require_shares(self, shares: np.ndarray) -> None:
        if shares.shape != (len(self.cells), len(Label)):
            raise ValueError(
                f"shares {shares.shape} must be (n_cell, n_label) = {len(self.cells), len(Label)}"
            )
        if not (np.all(shares >= 0) and np.allclose(shares.sum(axis=1), 1.0, rtol=0, atol=1e-6)):
            raise ValueError("shares of a cell's volume must be positive or zero, and sum to 1")
        if np.any(np.take_along_axis(shares, self.tissue[:, None].astype(int), 1)[:, 0] < shares.max(axis=1)):
            raise ValueError("tissue must be the label of the largest share; change both, or drop the shares")

    @property
    def composition(self) -> np.ndarray:
        """(n_cell, len(Label)): the shares, or 1 for the cell's tissue where there are none."""
        return np.eye(len(Label))[self.tissue] if self.shares is None else self.shares

    def moved_to(self, points: np.ndarray) -> "TetMesh":
        """The same mesh in another configuration, points (n_node, 3)."""
        return replace(self, points=points)

    def boundary_nodes(self, name: str) -> np.ndarray:
        """Sorted node numbers (n,) of the boundary with this name. Raises KeyError where there is none."""
        return np.unique(self.boundaries[name])
