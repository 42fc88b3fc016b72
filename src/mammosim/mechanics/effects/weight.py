"""Weight: dead loads of the tissues, a linear potential."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissues
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.mechanics.effects.protocol import NO_ELEMENTS, WithoutVolume
from mammosim.mechanics.mixture import cell_tissues
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import CELL_SHAPES, cell_quadrature


@dataclass(frozen=True)
class Weight(WithoutVolume):
    """E = - sum_a f_a . (x_a - X_a), f_a = integral of rho g N_a over the reference volume.

    points: X (n_node, 3) mm; forces: f (n_node, 3) mN.
    """

    points: np.ndarray
    forces: np.ndarray

    @classmethod
    def of(cls, mesh: TetMesh, tissues: Tissues, gravity: np.ndarray) -> "Weight":
        """Weight of a mesh whose points are the reference, along the unit vector gravity (3,).

        Raises MechanicsError for a tissue without parameters or a gravity that is no unit vector.
        """
        gravity = np.asarray(gravity, dtype=float)
        require_direction(gravity)
        weight_density = KPA_PER_MM_PER_G_CM3 * cell_tissues(mesh, tissues).density_g_cm3
        volumes = cell_quadrature(mesh.points, mesh.cells).volumes
        fe = np.einsum("e,eq,qa->ea", weight_density, volumes, CELL_SHAPES)
        forces = np.zeros_like(mesh.points)
        add_to_nodes(mesh.cells, fe[..., None] * gravity, forces)
        return cls(mesh.points, forces)

    @property
    def connectivity(self) -> np.ndarray:
        """None: the potential is linear."""
        return NO_ELEMENTS

    def energy(self, x: np.ndarray) -> float:
        """E = - sum_a f_a . (x_a - X_a)."""
        return -float(np.sum(self.forces * (x - self.points)))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """dE/dx_a = - f_a."""
        g -= self.forces

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """Zero."""


def require_direction(gravity: np.ndarray) -> None:
    """Raises MechanicsError for a gravity that is no unit vector (3,)."""
    if gravity.shape != (3,) or not np.isclose(np.linalg.norm(gravity), 1.0, atol=1e-6):
        raise MechanicsError(f"gravity {gravity} must be a unit vector (3,): give a direction, not 9.81")
