"""What a photon does that meets an atom: it is absorbed, or scattered by one electron or the whole atom.

x = E/(hc) sin(theta/2) in 1/Angstrom; k = E'/E = 1/(1 + E/(m c2) (1 - cos theta)).
Incoherent: d sigma/d cos = k^2 (k + 1/k - sin^2 theta) S(x); coherent: (1 + cos^2 theta) F(x)^2,
with S and F^2 of a material the means over its atoms (Hubbell et al. 1975, as tabulated by xraylib).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xraylib

from mammosim.xray.attenuation import ENERGY_LIMITS_KEV, Material, linear_attenuation
from mammosim.xray.random_stream import compiled, uniform

ELECTRON_REST_KEV = 510.99895  # CODATA 2018
HC_KEV_ANGSTROM = 12.398419843  # CODATA 2018, exact
LOWEST_KEV = ENERGY_LIMITS_KEV[0]
ENERGY_STEP_KEV = 0.05  # linear between: E^-3 is met to 2e-4 at 5 keV, 2e-5 at 17 keV
ROWS_PER_KEV = 1 / ENERGY_STEP_KEV
N_MOMENTUM = 1024
SMALLEST_X = 0.0011  # 1/Angstrom, where the tables of S(x) start; S is below 1e-3 there


class Matter(NamedTuple):
    """Tables of all materials: attenuation on an even grid of energies, and scattering on one of x.

    mu: (n_energy, n_material, 3) 1/mm: total, photoelectric, incoherent; S, area: (n_material, n_x);
    area: the integral of F^2 over x^2 from 0.
    """

    mu: np.ndarray
    S: np.ndarray
    area: np.ndarray
    x_step: float


def matter(materials: tuple[Material, ...], largest_kev: float) -> Matter:
    """Tables of the materials up to an energy. Raises XrayError for energies without cross-sections."""
    # ASSUME: absorbed energy stays in its voxel: no fluorescence, no bremsstrahlung, electrons do not travel.
    # ASSUME: electrons are free and at rest but for S(x): no Doppler broadening of the scattered energy.
    n = int(np.ceil((largest_kev - LOWEST_KEV) / ENERGY_STEP_KEV)) + 2
    E = LOWEST_KEV + ENERGY_STEP_KEV * np.arange(n)
    x, x_step = np.linspace(0.0, E[-1] / HC_KEV_ANGSTROM, N_MOMENTUM, retstep=True)
    mu = {
        process: np.stack([linear_attenuation(m, E, process=process) for m in materials], axis=1)
        for process in ("photoelectric", "incoherent", "coherent")
    }
    F2, S = _per_atom(materials, x, xraylib.FF_Rayl, 2), _per_atom(materials, x, xraylib.SF_Compt, 1)
    pieces = (F2[:, 1:] + F2[:, :-1]) / 2 * np.diff(x**2)
    area = np.concatenate([np.zeros((len(materials), 1)), np.cumsum(pieces, axis=1)], axis=1)
    total = np.sum(list(mu.values()), axis=0)
    return Matter(np.stack([total, mu["photoelectric"], mu["incoherent"]], axis=2), S, area, float(x_step))


def _per_atom(
    materials: tuple[Material, ...], x: np.ndarray, function: Callable[[int, float], float], power: int
) -> np.ndarray:
    """sum_i (w_i/A_i) function(Z_i, x)^power, (n_material, n_x)."""
    positive = np.maximum(x, SMALLEST_X)
    values = {
        Z: np.array([function(Z, q) ** power for q in positive]) / xraylib.AtomicWeight(Z)
        for Z in {Z for m in materials for Z, _ in m.fractions}
    }
    return np.array([sum(w * values[Z] for Z, w in m.fractions) for m in materials])


@compiled
def place(energy: float) -> tuple[int, float]:
    """Row of the energy tables below `energy`, and the share of the next row."""
    p = (energy - LOWEST_KEV) * ROWS_PER_KEV
    row = int(p)
    return row, p - row


@compiled
def between(table: np.ndarray, row: int, share: float, material: int, process: int) -> Any:
    """table[:, material, process] between a row and the next."""
    a = table[row, material, process]
    return a + share * (table[row + 1, material, process] - a)


@compiled
def incoherent(
    energy: float, material: int, S: np.ndarray, x_step: float, state: np.ndarray
) -> tuple[float, float]:
    """Scattered energy [keV] and cos(theta): even in cos, kept by k^2 (k + 1/k - sin^2) S / (2 S_max)."""
    row_scale = energy / HC_KEV_ANGSTROM / x_step
    S_max = at_momentum(S, material, row_scale)
    while True:
        cos = 2 * uniform(state) - 1
        k = 1 / (1 + energy / ELECTRON_REST_KEV * (1 - cos))
        f = k * k * (k + 1 / k - (1 - cos * cos)) / 2
        if uniform(state) * S_max < f * at_momentum(S, material, row_scale * math.sqrt((1 - cos) / 2)):
            return k * energy, cos


@compiled
def coherent(energy: float, material: int, area: np.ndarray, x_step: float, state: np.ndarray) -> Any:
    """cos(theta); x^2 is drawn from F^2 below (E/hc)^2 and kept with (1 + cos^2)/2."""
    x2_max = (energy / HC_KEV_ANGSTROM) ** 2
    last = int(math.sqrt(x2_max) / x_step)
    x2_last = (last * x_step) ** 2
    share = (x2_max - x2_last) / (((last + 1) * x_step) ** 2 - x2_last)
    total = area[material, last] + share * (area[material, last + 1] - area[material, last])
    while True:
        a = uniform(state) * total
        low, high = 0, last + 1
        while high - low > 1:
            middle = (low + high) // 2
            if area[material, middle] <= a:
                low = middle
            else:
                high = middle
        share = (a - area[material, low]) / (area[material, high] - area[material, low])
        x2 = x_step * x_step * (low * low + share * (high * high - low * low))
        cos = max(1 - 2 * x2 / x2_max, -1.0)
        if 2 * uniform(state) < 1 + cos * cos:
            return cos


@compiled
def at_momentum(table: np.ndarray, material: int, p: float) -> Any:
    """table[material] at x = p x_step."""
    row = int(p)
    return table[material, row] + (p - row) * (table[material, row + 1] - table[material, row])


@compiled
def turned(dx: float, dy: float, dz: float, cos: float, state: np.ndarray) -> tuple[float, float, float]:
    """The unit vector (dx, dy, dz) turned by theta, at a uniform azimuth."""
    phi = 2 * math.pi * uniform(state)
    sin = math.sqrt(max(1 - cos * cos, 0.0))
    a, b = sin * math.cos(phi), sin * math.sin(phi)
    # Duff et al. 2017: an orthonormal basis about d without a special direction
    sign = math.copysign(1.0, dz)
    p = -1 / (sign + dz)
    q = dx * dy * p
    return (
        a * (1 + sign * dx * dx * p) + b * q + cos * dx,
        a * sign * q + b * (sign + dy * dy * p) + cos * dy,
        -a * sign * dx - b * dy + cos * dz,
    )
