"""What hard cases are compared with: quantities of a state, and references from outside the solver."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import OneOf, Positive, Settings
from mammosim.core.tissues import Tissue
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.io.tabulated import tabulated
from mammosim.mechanics.reference import FACE_SHAPES, face_quadrature
from mammosim.study.hard_cases.bodies import Length
from mammosim.study.hard_cases.problems import TestProblem

# Greenhill 1881: a clamped column bends under its weight when rho g A L^3 / (E I) reaches this, j^2 9/4 with
# j = 1.86635 the first zero of the Bessel function of order -1/3.
GREENHILL = 7.8373


def apex_mm(problem: TestProblem, x: np.ndarray) -> float:
    """Displacement of the outermost point along z, outward."""
    apex = int(np.argmax(problem.mesh.points[:, 2]))
    return float((x - problem.mesh.points)[apex, 2])


def drop_mm(problem: TestProblem, x: np.ndarray) -> float:
    """Displacement of the outermost point along gravity."""
    apex = int(np.argmax(problem.mesh.points[:, 2]))
    return float((x - problem.mesh.points)[apex] @ _gravity(problem))


def tip_ratio(problem: TestProblem, x: np.ndarray) -> float:
    """Mean displacement along z of the face opposite z = 0, over the height."""
    L = problem.mesh.points[:, 2].max()
    end = np.isclose(problem.mesh.points[:, 2], L)
    return float((x - problem.mesh.points)[end, 2].mean() / L)


def slip_mm(problem: TestProblem, x: np.ndarray) -> float:
    """Mean displacement of `posterior` along the part of gravity in its plane z = 0."""
    faces = problem.mesh.boundaries["posterior"]
    areas = face_quadrature(problem.mesh.points, faces).areas
    u = np.einsum("qa,fai->fqi", FACE_SHAPES, (x - problem.mesh.points)[faces])
    along = _gravity(problem) * [1.0, 1.0, 0.0]
    return float(np.einsum("fq,fqi,i->", areas, u, along / np.linalg.norm(along)) / areas.sum())


def _gravity(problem: TestProblem) -> np.ndarray:
    if problem.gravity is None:
        raise ConfigurationError("the quantity compared needs a gravity; add one to the problem")
    return problem.gravity


QUANTITIES: Mapping[str, Callable[[TestProblem, np.ndarray], float]] = {
    "apex_mm": apex_mm,
    "drop_mm": drop_mm,
    "tip_ratio": tip_ratio,
    "slip_mm": slip_mm,
}


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
        """t with dW/dt = 0 for F = diag(stretch, 1, t), W = mu/2 (J^(-2/3) I1 - 3) + k/2 (J - 1)^2."""
        tissue = Tissue(self.youngs_modulus_kpa, self.poisson_ratio, 0.0)
        mu, k = tissue.shear_modulus_kpa, tissue.bulk_modulus_kpa

        def dW(t: float) -> float:
            J, I1 = stretch * t, stretch**2 + 1 + t**2
            return mu * J ** (-2 / 3) * (t - I1 / (3 * t)) + k * (J - 1) * stretch

        return float(brentq(dW, 0.2, 5.0, xtol=1e-15))


@dataclass(frozen=True)
class Laminate(Known):
    """apex_mm of layers one on the other, stretched along x in plane strain: each thins as it would alone."""

    stretch: Positive
    layers: tuple[Layer, ...]

    def value(self) -> float:
        return sum(layer.thickness_mm * (layer.thinned(self.stretch) - 1) for layer in self.layers)


REFERENCES = OneOf({
    "hemisphere": Hemisphere,
    "column": Column,
    "standing_column": StandingColumn,
    "greenhill": Greenhill,
    "rigid_slip": RigidSlip,
    "laminate": Laminate,
})  # fmt: skip
