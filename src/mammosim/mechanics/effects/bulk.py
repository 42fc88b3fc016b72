"""Bulk tissue: compressible neo-Hookean solid elements.

W = mu/2 (I1bar - 3) + k/2 (J - 1)^2,  I1bar = J^(-2/3) I1,  I1 = tr(F^T F),  J = det F,  C = cof F = J F^-T
P = dW/dF = mu J^(-2/3) F + s C,  s = p - mu/3 J^(-5/3) I1,  p = k (J - 1)
dP = mu J^(-2/3) dF - 2/3 mu J^(-5/3) (F (C:dF) + C (F:dF)) + (5/9 mu J^(-8/3) I1 + k) C (C:dF) + s dC
"""

# ASSUME: the bulk law has the isochoric I1bar where [@mira2018] prints I1, which would stress the rest state.

from dataclasses import dataclass, replace

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissues
from mammosim.mechanics.effects import bulk_kernels as kernels
from mammosim.mechanics.effects.bulk_projection import project_tangents
from mammosim.mechanics.mixture import cell_tissues
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import CellQuadrature, cell_quadrature


@dataclass(frozen=True)
class NeoHookean:
    """The elastic energy of all cells.

    cells (n_cell, 10); mu, k (n_cell,) kPa; pressure (n_cell, 4) kPa: p of the tangent if predicted.
    """

    cells: np.ndarray
    quadrature: CellQuadrature
    mu: np.ndarray
    k: np.ndarray
    pressure: np.ndarray | None = None

    @classmethod
    def of(cls, mesh: TetMesh, tissues: Tissues) -> "NeoHookean":
        """The cells of a mesh whose points are the reference. Raises MechanicsError for an unknown tissue."""
        each = cell_tissues(mesh, tissues)
        quadrature = cell_quadrature(mesh.points, mesh.cells)
        return cls(mesh.cells, quadrature, each.shear_modulus_kpa, each.bulk_modulus_kpa)

    @property
    def connectivity(self) -> np.ndarray:
        """The cells."""
        return self.cells

    def energy(self, x: np.ndarray) -> float:
        """The integral of W; infinite where J <= 0 at an integration point."""
        return float(np.sum(self.energies(x)))

    def energies(self, x: np.ndarray) -> np.ndarray:
        """The integral of W over each cell (n_cell,)."""
        q = self.quadrature
        return kernels.energies(x, self.cells, q.gradients, q.volumes, self.mu, self.k)

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of P dN_a/dX."""
        add_to_nodes(self.cells, self.cell_forces(x), g)

    def cell_forces(self, x: np.ndarray) -> np.ndarray:
        """Of each cell on its nodes (n_cell, 10, 3) mN: what add_gradient adds up."""
        return self.cell_forces_under(x, self.k[:, None] * (self.volume_ratios(x) - 1))

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of dN_a/dX . d2W/dF2 . dN_b/dX."""
        self.add_tangent_under(x, self.tangent_pressure(x), K, projected=projected)

    def cell_forces_under(self, x: np.ndarray, p: np.ndarray) -> np.ndarray:
        """As cell_forces, with given pressures p (n_cell, 4) kPa."""
        q = self.quadrature
        found: np.ndarray = kernels.gradients(x, self.cells, q.gradients, q.volumes, self.mu, p)
        return found

    def add_tangent_under(self, x: np.ndarray, p: np.ndarray, K: Tangent, *, projected: bool) -> None:
        """As add_tangent, with given pressures p (n_cell, 4) kPa; dp = k dJ as ever."""
        K.add_in_batches(self.cells, lambda batch: self._element_tangents(x, p, batch, projected))

    def _element_tangents(self, x: np.ndarray, p: np.ndarray, batch: slice, projected: bool) -> np.ndarray:
        """Those of a slice of the cells, (n_in_batch, 10, 10, 3, 3) mN/mm."""
        q = self.quadrature
        each = (self.cells, q.gradients, q.volumes, self.mu, self.k, p)
        cells, dN, dV, mu, k, p = (values[batch] for values in each)
        Ke = kernels.tangents(x, cells, dN, dV, mu, k, p)
        if projected:
            project_tangents(Ke, x, cells, dN, dV, mu, k, p)
        return Ke

    def tangent_pressure(self, x: np.ndarray) -> np.ndarray:
        """p (n_cell, 4) kPa of the tangent: predicted, or else k (J - 1)."""
        return self.k[:, None] * (self.volume_ratios(x) - 1) if self.pressure is None else self.pressure

    def volume_ratios(self, x: np.ndarray) -> np.ndarray:
        """J (n_cell, 4) at the integration points."""
        return kernels.volume_ratios(x, self.cells, self.quadrature.gradients)

    def smallest_J(self, x: np.ndarray) -> float:
        """The smallest J of the integration points."""
        return float(self.volume_ratios(x).min())

    def softened(self, ratio: float) -> "NeoHookean":
        """The law with k' = min(k, ratio mu): the part of it that displacements alone can follow."""
        return replace(self, k=np.minimum(self.k, ratio * self.mu))

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> "NeoHookean":
        """The law with the pressure that the step predicts, p = k (J - 1 + C : grad dx), in its tangent.

        Newton with mixed integration points (Magisano, Leonetti & Garcea 2017): near incompressibility the
        pressure of the displaced shape is wrong by k times the square of the step, the predicted one is not.
        """
        return replace(self, pressure=self.k[:, None] * self.predicted_changes(x, dx))

    def predicted_changes(self, x: np.ndarray, dx: np.ndarray) -> np.ndarray:
        """J - 1 + C : grad dx (n_cell, 4)."""
        return kernels.predicted_changes(x, dx, self.cells, self.quadrature.gradients)
