"""What quantities of hard cases are compared with: references from outside the solver, or finer meshes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from mammosim.core.settings import OneOf, Positive, Settings
from mammosim.core.tissues import Tissue
from mammosim.core.units import KPA_PER_MM_PER_G_CM3, MN_PER_N
from mammosim.io.tabulated import tabulated
from mammosim.study.hard_cases.bodies import Length

# Greenhill 1881: a clamped column bends under its weight when rho g A L^3 / (E I) reaches this, j^2 9/4 with
# j = 1.86635 the first zero of the Bessel function of order -1/3.
GREENHILL = 7.8373


class Known(Settings):
    """A reference; mm where its quantity is, no unit otherwise."""

    def value(self) -> float:
        """The right number."""
        raise NotImplementedError


@dataclass(frozen=True)
class Refined(Settings):
    """The same problem with elements of edge_mm by this solver, where nothing independent is known."""

    edge_mm: Length


@dataclass(frozen=True)
class Hemisphere(Known):
    """apex_mm of the table hemisphere_gravity."""

    case: str

    def value(self) -> float:
        return float(tabulated("hemisphere_gravity").set_index("case").apex_mm[self.case])


@dataclass(frozen=True)
class Column(Known):
    """tip_ratio of the table column_gravity."""

    nu: float
    q: float
    direction: Literal["hang", "stand"]

    def value(self) -> float:
        table = tabulated("column_gravity").set_index(["nu", "q", "direction"]).tip_ratio
        return float(table[self.nu, self.q, self.direction])


@dataclass(frozen=True)
class StandingColumn(Known):
    """tip_ratio of a straight column under its weight for small strain, - rho g L / (2 E)."""

    youngs_modulus_kpa: Positive
    density_g_cm3: Positive
    height_mm: Length

    def value(self) -> float:
        rho_g = KPA_PER_MM_PER_G_CM3 * self.density_g_cm3
        return -rho_g * self.height_mm / (2 * self.youngs_modulus_kpa)


@dataclass(frozen=True)
class Greenhill(Known):
    """Load factor at which a square column bends, GREENHILL E I / (rho g A L^3), I / A = side^2 / 12."""

    youngs_modulus_kpa: Positive
    density_g_cm3: Positive
    height_mm: Length
    side_mm: Length

    def value(self) -> float:
        rho_g = KPA_PER_MM_PER_G_CM3 * self.density_g_cm3
        return GREENHILL * self.youngs_modulus_kpa * self.side_mm**2 / (12 * rho_g * self.height_mm**3)


@dataclass(frozen=True)
class RigidSlip(Known):
    """slip_mm by the balance of forces alone, rho g V sin(tilt) / (kappa A); thickness V / A."""

    density_g_cm3: Positive
    thickness_mm: Length
    kappa_kpa_mm: Positive
    degrees: float

    def value(self) -> float:
        pressure = KPA_PER_MM_PER_G_CM3 * self.density_g_cm3 * self.thickness_mm
        return pressure * np.sin(np.radians(self.degrees)) / self.kappa_kpa_mm


@dataclass(frozen=True)
class Layer(Settings):
    """Of a laminate."""

    thickness_mm: Length
    youngs_modulus_kpa: Positive
    poisson_ratio: float

    def thinned(self, stretch: float) -> float:
        """t with no stress across the layer for F = diag(stretch, 1, t)."""
        tissue = Tissue(self.youngs_modulus_kpa, self.poisson_ratio, 0.0)
        return _root(lambda t: nominal_stresses(tissue, np.array([stretch, 1.0, t]))[2], 0.2)


def nominal_stresses(tissue: Tissue, stretches: np.ndarray) -> np.ndarray:
    """P_i = dW/dl_i = mu J^(-2/3) (l_i - I1 / (3 l_i)) + k (J - 1) J / l_i (3,) kPa for F = diag(l).

    W = mu/2 (J^(-2/3) I1 - 3) + k/2 (J - 1)^2; stretches l (3,).
    """
    mu, k = tissue.shear_modulus_kpa, tissue.bulk_modulus_kpa
    J, I1 = np.prod(stretches), np.sum(stretches**2)
    P: np.ndarray = mu * J ** (-2 / 3) * (stretches - I1 / (3 * stretches)) + k * (J - 1) * J / stretches
    return P


def _root(f: Callable[[float], float], least: float) -> float:
    return float(brentq(f, least, 5.0, xtol=1e-15))


@dataclass(frozen=True)
class Laminate(Known):
    """apex_mm of layers one on the other, stretched along x in plane strain: each thins as it would alone."""

    stretch: Positive
    layers: tuple[Layer, ...]

    def value(self) -> float:
        return sum(layer.thickness_mm * (layer.thinned(self.stretch) - 1) for layer in self.layers)


@dataclass(frozen=True)
class Part(Settings):
    """Of the cross-section of a block."""

    area_mm2: Positive
    youngs_modulus_kpa: Positive
    poisson_ratio: float

    def tissue(self) -> Tissue:
        """Without density."""
        return Tissue(self.youngs_modulus_kpa, self.poisson_ratio, 0.0)


@dataclass(frozen=True)
class ConfinedBlock(Known):
    """force_n of a block pressed to a stretch that cannot widen: - sum A P_2 for F = diag(1, stretch, 1)."""

    stretch: Positive
    parts: tuple[Part, ...]

    def value(self) -> float:
        stretches = np.array([1.0, self.stretch, 1.0])
        forces = [part.area_mm2 * nominal_stresses(part.tissue(), stretches)[1] for part in self.parts]
        return -float(sum(forces)) / MN_PER_N


@dataclass(frozen=True)
class FreeBlock(Known):
    """Of a block pressed to a stretch below 1 that widens freely, F = diag(t, stretch, t) with P_1 = P_3 = 0.

    force_n, or width_mm of its size along x: (t - 1) size.
    """

    stretch: Positive
    part: Part
    width_mm: Length | None = None

    def value(self) -> float:
        tissue = self.part.tissue()

        def stresses(t: float) -> np.ndarray:
            return nominal_stresses(tissue, np.array([t, self.stretch, t]))

        t = _root(lambda t: stresses(t)[0], 1.0)
        if self.width_mm is not None:
            return (t - 1) * self.width_mm
        return float(-self.part.area_mm2 * stresses(t)[1] / MN_PER_N)


@dataclass(frozen=True)
class Hertz(Known):
    """Of a ball between two plates, each d into it, small against its radius R, E* = E / (1 - nu^2).

    force_n 4/3 E* R^(1/2) d^(3/2), contact_area_mm2 pi R d, or pressure_kpa, the one over the other, each
    times the part of the ball that is modelled (the pressure is not).
    """

    of: Literal["force_n", "contact_area_mm2", "pressure_kpa"]
    radius_mm: Length
    depth_mm: Length
    youngs_modulus_kpa: Positive
    poisson_ratio: float
    modelled: Positive = 1.0

    def value(self) -> float:
        R, d = self.radius_mm, self.depth_mm
        F = 4 / 3 * self.youngs_modulus_kpa / (1 - self.poisson_ratio**2) * R**0.5 * d**1.5
        A = np.pi * R * d
        return {
            "force_n": self.modelled * F / MN_PER_N,
            "contact_area_mm2": self.modelled * A,
            "pressure_kpa": F / A,
        }[self.of]


REFERENCES = OneOf({
    "hemisphere": Hemisphere,
    "column": Column,
    "standing_column": StandingColumn,
    "greenhill": Greenhill,
    "rigid_slip": RigidSlip,
    "laminate": Laminate,
    "confined_block": ConfinedBlock,
    "free_block": FreeBlock,
    "hertz": Hertz,
})  # fmt: skip
