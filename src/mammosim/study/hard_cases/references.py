"""What hard cases are compared with: quantities of a state, and references from outside the solver."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.optimize import brentq

from mammosim.core.errors import ConfigurationError
from mammosim.core.tissues import Tissue
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.io.tabulated import tabulated
from mammosim.mechanics.reference import FACE_SHAPES, face_quadrature
from mammosim.study.hard_cases.scenes import Scene

# Greenhill 1881: a clamped column bends under its weight when rho g A L^3 / (E I) reaches this, j^2 9/4 with
# j = 1.86635 the first zero of the Bessel function of order -1/3.
GREENHILL = 7.8373


def apex_mm(scene: Scene, x: np.ndarray) -> float:
    """Displacement of the outermost point along z, outward."""
    apex = int(np.argmax(scene.mesh.points[:, 2]))
    return float((x - scene.mesh.points)[apex, 2])


def drop_mm(scene: Scene, x: np.ndarray) -> float:
    """Displacement of the outermost point along gravity."""
    apex = int(np.argmax(scene.mesh.points[:, 2]))
    return float((x - scene.mesh.points)[apex] @ _gravity(scene))


def tip_ratio(scene: Scene, x: np.ndarray) -> float:
    """Mean displacement along z of the face opposite z = 0, over the height."""
    L = scene.mesh.points[:, 2].max()
    end = np.isclose(scene.mesh.points[:, 2], L)
    return float((x - scene.mesh.points)[end, 2].mean() / L)


def slip_mm(scene: Scene, x: np.ndarray) -> float:
    """Mean displacement of `posterior` along the part of gravity in its plane z = 0."""
    faces = scene.mesh.boundaries["posterior"]
    areas = face_quadrature(scene.mesh.points, faces).areas
    u = np.einsum("qa,fai->fqi", FACE_SHAPES, (x - scene.mesh.points)[faces])
    along = _gravity(scene) * [1.0, 1.0, 0.0]
    return float(np.einsum("fq,fqi,i->", areas, u, along / np.linalg.norm(along)) / areas.sum())


def _gravity(scene: Scene) -> np.ndarray:
    if scene.gravity is None:
        raise ConfigurationError("the quantity asked needs a gravity; add one to the scene")
    return scene.gravity


QUANTITIES: Mapping[str, Callable[[Scene, np.ndarray], float]] = {
    "apex_mm": apex_mm,
    "drop_mm": drop_mm,
    "tip_ratio": tip_ratio,
    "slip_mm": slip_mm,
}


def hemisphere(*, case: str) -> float:
    """apex_mm of the table hemisphere_gravity."""
    return float(tabulated("hemisphere_gravity").set_index("case").apex_mm[case])


def column(*, nu: float, q: float, direction: str) -> float:
    """tip_ratio of the table column_gravity."""
    table = tabulated("column_gravity").set_index(["nu", "q", "direction"]).tip_ratio
    return float(table[nu, q, direction])


def standing_column(*, youngs_modulus_kpa: float, density_g_cm3: float, height_mm: float) -> float:
    """tip_ratio of a straight column under its weight for small strain, - rho g L / (2 E)."""
    return -KPA_PER_MM_PER_G_CM3 * density_g_cm3 * height_mm / (2 * youngs_modulus_kpa)


def greenhill(*, youngs_modulus_kpa: float, density_g_cm3: float, height_mm: float, side_mm: float) -> float:
    """Load factor at which a square column bends, GREENHILL E I / (rho g A L^3), I / A = side^2 / 12."""
    rho_g = KPA_PER_MM_PER_G_CM3 * density_g_cm3
    return GREENHILL * youngs_modulus_kpa * side_mm**2 / (12 * rho_g * height_mm**3)


def rigid_slip(*, density_g_cm3: float, thickness_mm: float, kappa_kpa_mm: float, degrees: float) -> float:
    """slip_mm by the balance of forces alone, rho g V sin(tilt) / (kappa A); thickness V / A."""
    pressure = KPA_PER_MM_PER_G_CM3 * density_g_cm3 * thickness_mm
    return pressure * np.sin(np.radians(degrees)) / kappa_kpa_mm


def laminate(*, stretch: float, layers: list[Mapping[str, float]]) -> float:
    """apex_mm of layers one on the other, stretched along x in plane strain: each thins as it would alone."""
    return sum(layer["thickness_mm"] * (_thinned(stretch, layer) - 1) for layer in layers)


def _thinned(stretch: float, layer: Mapping[str, float]) -> float:
    """t with dW/dt = 0 for F = diag(stretch, 1, t), W = mu/2 (J^(-2/3) I1 - 3) + k/2 (J - 1)^2."""
    tissue = Tissue(layer["youngs_modulus_kpa"], layer["poisson_ratio"], 0.0)
    mu, k = tissue.shear_modulus_kpa, tissue.bulk_modulus_kpa

    def dW(t: float) -> float:
        J, I1 = stretch * t, stretch**2 + 1 + t**2
        return mu * J ** (-2 / 3) * (t - I1 / (3 * t)) + k * (J - 1) * stretch

    return float(brentq(dW, 0.2, 5.0, xtol=1e-15))


REFERENCES: Mapping[str, Callable[..., float]] = {
    "hemisphere": hemisphere,
    "column": column,
    "standing_column": standing_column,
    "greenhill": greenhill,
    "rigid_slip": rigid_slip,
    "laminate": laminate,
}


def reference(values: Mapping[str, Mapping[str, Any]]) -> float:
    """The number of {name of REFERENCES: its values}."""
    ((name, given),) = values.items()
    return REFERENCES[name](**given)
