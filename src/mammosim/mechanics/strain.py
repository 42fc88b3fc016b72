"""Strain of cells between the reference and a loaded shape."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.reference import cell_quadrature


@dataclass(frozen=True)
class CellStrain:
    """Averages over the reference volume of each cell.

    F (n_cell, 3, 3) = dx/dX; J (n_cell,): volume ratio of the cell; principal (n_cell, 3): ascending
    principal values of the Green-Lagrange strain E = (F^T F - 1) / 2; volume (n_cell,): reference, mm3.
    """

    F: np.ndarray
    J: np.ndarray
    principal: np.ndarray
    volume: np.ndarray

    @property
    def logarithmic(self) -> np.ndarray:
        """Ascending principal values (n_cell, 3) of Hencky's strain ln U = ln(2 E + 1) / 2, U^2 = F^T F."""
        H: np.ndarray = np.log1p(2 * self.principal) / 2
        return H


def cell_strain(mesh: TetMesh, x: np.ndarray) -> CellStrain:
    """Strain of the cells of a mesh, whose points are the reference, in the loaded shape x (n_node, 3)."""
    quadrature = cell_quadrature(mesh.points, mesh.cells)
    F = np.einsum("eai,eqaj->eqij", x[mesh.cells], quadrature.gradients)
    volume = quadrature.volumes.sum(axis=1)
    weights = quadrature.volumes / volume[:, None]
    mean_F = np.einsum("eq,eqij->eij", weights, F)
    J = np.einsum("eq,eq->e", weights, np.linalg.det(F))
    E = (np.swapaxes(mean_F, 1, 2) @ mean_F - np.eye(3)) / 2
    return CellStrain(mean_F, J, np.linalg.eigvalsh(E), volume)
