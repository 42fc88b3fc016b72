"""Strain of cells between the reference and a loaded shape."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.reference import cell_quadrature


@dataclass(frozen=True)
class CellStrain:
    """Averages over the reference volume of each cell.

    F (n_cell, 3, 3) = dx/dX; J (n_cell,): volume ratio of the cell; principal (n_cell, 3): ascending
    principal values of the Green-Lagrange strain E = (F^T F - 1) / 2.
    """

    F: np.ndarray
    J: np.ndarray
    principal: np.ndarray


def cell_strain(mesh: TetMesh, x: np.ndarray) -> CellStrain:
    """Strain of the cells of a mesh, whose points are the reference, in the loaded shape x (n_node, 3)."""
    quadrature = cell_quadrature(mesh.points, mesh.cells)
    F = np.einsum("eai,eqaj->eqij", x[mesh.cells], quadrature.gradients)
    weights = quadrature.volumes / quadrature.volumes.sum(axis=1, keepdims=True)
    mean_F = np.einsum("eq,eqij->eij", weights, F)
    J = np.einsum("eq,eq->e", weights, np.linalg.det(F))
    E = (np.swapaxes(mean_F, 1, 2) @ mean_F - np.eye(3)) / 2
    return CellStrain(mean_F, J, np.linalg.eigvalsh(E))
