"""Weight: dead loads of the tissues, a linear potential.

Buoyancy: water carries a body up to its level, as much as the water weighs that the body displaces.

    E = gamma integral of psi(d) over the reference volume,  d = g . x - s: depth under the level s
    psi = 0 for d < -w/2,  (d + w/2)^2 / (2 w) between,  d for d > w/2;  force -gamma psi'(d) g per volume

gamma: weight density of the water; g: direction of gravity. psi is convex: what sinks is pushed up more.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissues
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
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


# ASSUME: water does not compress tissue: its pressure, less what balances it inside, is an upward body force.
# ASSUME: the waterline is smeared over a stated height, so that force is continuous where tissue crosses it.


@dataclass(frozen=True)
class Buoyancy(WithoutVolume):
    """cells (n_cell, 10), volumes (n_cell, 4) mm3, gravity g (3,), gamma kPa/mm, level s mm, waterline w mm.

    Raises MechanicsError for a gravity that is no unit vector, gamma < 0 or w <= 0.
    """

    cells: np.ndarray
    volumes: np.ndarray
    gravity: np.ndarray
    weight_density: float
    level: float
    waterline: float

    def __post_init__(self) -> None:
        require_direction(self.gravity)
        if self.weight_density < 0 or self.waterline <= 0:
            raise MechanicsError(
                f"water of {self.weight_density:g} kPa/mm (at least 0) with a waterline of "
                f"{self.waterline:g} mm (above 0): give a density near 1 g/cm3 and a few mm"
            )

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        gravity: np.ndarray,
        *,
        level_mm: float,
        density_g_cm3: float = 1.0,
        waterline_mm: float = 2.0,
    ) -> "Buoyancy":
        """Buoyancy of a mesh whose points are the reference; level_mm: g . x of the water's surface.

        Raises MechanicsError as the class does.
        """
        gamma = KPA_PER_MM_PER_G_CM3 * density_g_cm3
        volumes = cell_quadrature(mesh.points, mesh.cells).volumes
        return cls(mesh.cells, volumes, np.asarray(gravity, dtype=float), gamma, level_mm, waterline_mm)

    @property
    def connectivity(self) -> np.ndarray:
        """The cells."""
        return self.cells

    def depths(self, x: np.ndarray) -> np.ndarray:
        """d (n_cell, 4) mm of the integration points, positive under water."""
        d: np.ndarray = positions(x, self.cells, CELL_SHAPES) @ self.gravity - self.level
        return d

    def energy(self, x: np.ndarray) -> float:
        """E = gamma integral of psi."""
        d, w = self.depths(x), self.waterline
        psi = np.where(d > w / 2, d, np.maximum(d + w / 2, 0.0) ** 2 / (2 * w))
        return self.weight_density * float(np.sum(self.volumes * psi))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of gamma psi' N_a g."""
        immersed = np.clip(self.depths(x) / self.waterline + 0.5, 0.0, 1.0)
        t = self.weight_density * (self.volumes * immersed)[..., None] * self.gravity
        add_to_nodes(self.cells, gathered_forces(t, CELL_SHAPES), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of gamma psi'' N_a N_b g (x) g, positive semidefinite as psi is convex."""
        crossing = np.abs(self.depths(x)) <= self.waterline / 2
        if np.any(crossing):
            m = self.weight_density / self.waterline * self.volumes * crossing
            M = m[..., None, None] * np.outer(self.gravity, self.gravity)
            K.add(self.cells, gathered_stiffness(M, CELL_SHAPES))
