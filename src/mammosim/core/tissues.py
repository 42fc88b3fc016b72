"""What a tissue is made of, mechanically."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label

# A modulus above this was almost certainly given in Pa: tendon, the stiffest soft tissue, is about 1e6 kPa.
LARGEST_MODULUS_KPA = 1e5
# What has a modulus, in the order of every table of moduli.
WITH_MODULUS = ("adipose", "glandular", "skin", "fascia", "muscle")


@dataclass(frozen=True)
class Tissue:
    """Isotropic neo-Hookean tissue.

    youngs_modulus_kpa: E; poisson_ratio: nu [-]; density_g_cm3: density.
    Raises MechanicsError when E <= 0 or looks like Pa, nu is outside [0, 0.5), or density < 0.
    """

    youngs_modulus_kpa: float
    poisson_ratio: float
    density_g_cm3: float

    def __post_init__(self) -> None:
        E, nu = self.youngs_modulus_kpa, self.poisson_ratio
        if not 0 < E <= LARGEST_MODULUS_KPA:
            raise MechanicsError(
                f"youngs_modulus_kpa = {E:g} is outside (0, {LARGEST_MODULUS_KPA:g}]; "
                "soft tissue has 0.1 to 200 kPa: was it given in Pa? divide by 1000"
            )
        if not 0 <= nu < 0.5:
            raise MechanicsError(f"poisson_ratio = {nu:g} is outside [0, 0.5); use 0.45 or 0.495")
        if not 0 <= self.density_g_cm3 < math.inf:
            raise MechanicsError(
                f"density_g_cm3 = {self.density_g_cm3:g} is negative or no number; tissue has about 1"
            )

    @property
    def shear_modulus_kpa(self) -> float:
        """mu = E / (2 (1 + nu))."""
        return self.youngs_modulus_kpa / (2 * (1 + self.poisson_ratio))

    @property
    def bulk_modulus_kpa(self) -> float:
        """k = E / (3 (1 - 2 nu))."""
        return self.youngs_modulus_kpa / (3 * (1 - 2 * self.poisson_ratio))


@dataclass(frozen=True)
class CellTissues:
    """The tissue of every cell of a mesh: E [kPa], nu [-], density [g/cm3], (n_cell,) each; limits of Tissue.

    For moduli that differ within a tissue, such as left and right, and for cells of several tissues.
    """

    youngs_modulus_kpa: np.ndarray
    poisson_ratio: np.ndarray
    density_g_cm3: np.ndarray

    def __post_init__(self) -> None:
        columns = (self.youngs_modulus_kpa, self.poisson_ratio, self.density_g_cm3)
        if len({np.shape(column) for column in columns}) != 1:
            raise MechanicsError("youngs_modulus_kpa, poisson_ratio, density_g_cm3 must each be (n_cell,)")
        for extreme in (np.min, np.max):
            Tissue(*(float(extreme(column)) for column in columns))

    @property
    def shear_modulus_kpa(self) -> np.ndarray:
        """mu = E / (2 (1 + nu))."""
        mu: np.ndarray = self.youngs_modulus_kpa / (2 * (1 + self.poisson_ratio))
        return mu

    @property
    def bulk_modulus_kpa(self) -> np.ndarray:
        """k = E / (3 (1 - 2 nu))."""
        k: np.ndarray = self.youngs_modulus_kpa / (3 * (1 - 2 * self.poisson_ratio))
        return k


@dataclass(frozen=True)
class Membrane:
    """A skin as a file of tissues gives it: E [kPa], nu [-], thickness [mm]; limits of Tissue.

    Raises MechanicsError for a modulus or a Poisson's ratio as Tissue does, and for another thickness.
    """

    youngs_modulus_kpa: float
    poisson_ratio: float
    thickness_mm: float

    def __post_init__(self) -> None:
        Tissue(self.youngs_modulus_kpa, self.poisson_ratio, 1.0)
        if not 0 < self.thickness_mm <= 10:
            raise MechanicsError(
                f"thickness_mm = {self.thickness_mm:g} is outside (0, 10]; skin has 0.5 to 3 mm: in cm?"
            )


@dataclass(frozen=True)
class TissueTable:
    """A file of config/tissues: the solid tissues by name, and the skin, None where the file has none.

    Raises MechanicsError for a tissue that is none of core.labels.Label.
    """

    tissues: Mapping[str, Tissue]
    skin: Membrane | None = None

    def __post_init__(self) -> None:
        known = [label.tissue for label in Label]
        if unknown := sorted(set(self.tissues) - set(known)):
            raise MechanicsError(f"unknown tissue {unknown[0]!r}; choose among: {', '.join(known)}")

    @property
    def by_label(self) -> dict[Label, Tissue]:
        """The solid tissues by their label."""
        return {Label[name.upper()]: tissue for name, tissue in self.tissues.items()}


Tissues = Mapping[Label, Tissue] | CellTissues


def tissue_of(label: int, tissues: Mapping[Label, Tissue]) -> Tissue:
    """The parameters of one label. Raises MechanicsError when the table has none."""
    try:
        return tissues[Label(label)]
    except KeyError:
        known = ", ".join(sorted(key.tissue for key in tissues))
        raise MechanicsError(
            f"tissue {Label(label).tissue!r} is in the mesh but has no parameters; the table has: {known}"
        ) from None


def tissues_by_label(table: Mapping[str, Mapping[str, float]]) -> dict[Label, Tissue]:
    """Tissues of a table {'adipose': {youngs_modulus_kpa, poisson_ratio, density_g_cm3}, ...}."""
    return {Label[name.upper()]: Tissue(**values) for name, values in table.items()}
