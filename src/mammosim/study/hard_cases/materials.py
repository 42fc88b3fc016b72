"""What the bodies of the hard cases are made of: tissues by name, and moduli that vary at random.

E(X) = E_tissue exp(sigma z(X)),  z of mean 0 and variance 1: independent of cell to cell, or smooth,
z(X) = sqrt(2 / m) sum cos(k_i . X + phi_i),  k_i normal with 1 / l in each direction, phi_i uniform,

which depends on the place alone, so that a finer mesh of the same body has the same moduli.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.settings import Limits, Positive, Settings, Unchecked
from mammosim.core.tissues import Tissues, tissues_by_label
from mammosim.mechanics.mixture import cell_tissues
from mammosim.study.hard_cases.bodies import middles_of

_WAVES = 64  # m


@dataclass(frozen=True)
class TissueValues(Settings):
    """As configured: values that cannot be are for the mechanics to reject."""

    youngs_modulus_kpa: Unchecked
    poisson_ratio: Unchecked
    density_g_cm3: Unchecked


@dataclass(frozen=True)
class SkinValues(Settings):
    """As configured, a membrane; as TissueValues."""

    youngs_modulus_kpa: Unchecked
    poisson_ratio: Unchecked
    thickness_mm: Unchecked


TissueNames = Literal["adipose", "skin", "muscle", "lesion"]


@dataclass(frozen=True)
class Scatter(Settings):
    """Moduli at random: sigma of ln E; correlation_mm: l of a smooth field, None for cell by cell."""

    seed: int
    sigma: Positive
    correlation_mm: Annotated[float, Limits(above=0, at_most=1000)] | None = None

    def factors(self, mesh: TetMesh) -> np.ndarray:
        """exp(sigma z) of each cell (n_cell,)."""
        rng = generator("hard cases", "scatter", self.seed)
        if self.correlation_mm is None:
            return np.exp(self.sigma * rng.standard_normal(len(mesh.cells)))
        k = rng.standard_normal((3, _WAVES)) / self.correlation_mm
        phi = rng.uniform(0, 2 * np.pi, _WAVES)
        z = np.sqrt(2 / _WAVES) * np.cos(middles_of(mesh) @ k + phi).sum(axis=1)
        return np.exp(self.sigma * z)


def tissues_of(mesh: TetMesh, values: Mapping[TissueNames, TissueValues], scatter: Scatter | None) -> Tissues:
    """Of a mesh at rest. Raises MechanicsError for values that cannot be."""
    tissues = tissues_by_label({str(name): vars(each) for name, each in values.items()})
    if scatter is None:
        return tissues
    cells = cell_tissues(mesh, tissues)
    return replace(cells, youngs_modulus_kpa=cells.youngs_modulus_kpa * scatter.factors(mesh))
