"""Buoyancy: water carries a body up to its level, as much as the water weighs that the body displaces.

    E = gamma integral of psi(d) over the reference volume,  d = g . x - s: depth under the level s
    psi = 0 for d < -w/2,  (d + w/2)^2 / (2 w) between,  d for d > w/2;  force -gamma psi'(d) g per volume

gamma: weight density of the water; g: direction of gravity. psi is convex: what sinks is pushed up more.
"""

# ASSUME: water does not compress tissue: its pressure, less what balances it inside, is an upward body force.
# ASSUME: the waterline is smeared over a stated height, so that force is continuous where tissue crosses it.

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.effects.weight import require_direction
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import CELL_SHAPES, cell_quadrature


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
