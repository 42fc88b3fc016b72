"""What materials are made of, and how they attenuate photons: mu = rho sum_i w_i (mu/rho)_i.

Cross-sections per element are those of xraylib (Schoonjans et al. 2011, Spectrochim Acta B 66:776).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import xraylib

from mammosim.core.errors import XrayError
from mammosim.core.units import MM_PER_CM
from mammosim.io.tabulated import tabulated

ENERGY_LIMITS_KEV = (1.0, 100.0)
FRACTION_TOLERANCE = 2e-3  # printed compositions are rounded to 0.1 percent of the weight

PROCESSES: Mapping[str, Callable[[int, float], float]] = {
    "total": xraylib.CS_Total,
    "photoelectric": xraylib.CS_Photo,
    "incoherent": xraylib.CS_Compt,
    "coherent": xraylib.CS_Rayl,
}


@dataclass(frozen=True)
class Material:
    """A name, a density, and the weight fraction w of each atomic number Z: ((Z, w), ...).

    Raises XrayError when the density is not positive, or the fractions are negative or do not add to one.
    """

    name: str
    density_g_cm3: float
    fractions: tuple[tuple[int, float], ...]

    def __post_init__(self) -> None:
        if not 0 < self.density_g_cm3 < 25:
            raise XrayError(f"density of {self.name} = {self.density_g_cm3} g/cm3 is outside (0, 25)")
        w = np.array([fraction for _, fraction in self.fractions])
        if not (abs(w.sum() - 1) <= FRACTION_TOLERANCE and np.all(w >= 0)):
            raise XrayError(f"weight fractions of {self.name} add to {w.sum():g}; they must add to 1")


@lru_cache
def materials() -> Mapping[str, Material]:
    """Every material of the table `compositions`, by name."""
    table = tabulated("compositions").set_index("material")
    columns = [name for name in table.columns if name.startswith("weight_percent_z")]
    found = {}
    for name, row in table.iterrows():
        parts = tuple(
            (int(c.removeprefix("weight_percent_z")), float(row[c]) / 100) for c in columns if row[c]
        )
        found[str(name)] = Material(str(name), float(row["density_g_cm3"]), parts)
    return found


def material(name: str) -> Material:
    """One material of the table. Raises XrayError when it has no such material."""
    if name not in materials():
        raise XrayError(f"unknown material {name!r}; choose one of: {', '.join(sorted(materials()))}")
    return materials()[name]


def mixture(
    name: str, parts: tuple[tuple[Material, float], ...], *, density_g_cm3: float | None = None
) -> Material:
    """Materials mixed by weight, w_Z = sum_j W_j w_Z,j; without a density 1/rho = sum_j W_j/rho_j.

    Raises XrayError when the weights W do not add to one.
    """
    # ASSUME: volumes add when tissues are mixed by weight, unless a density is given.
    rho = density_g_cm3 or 1 / sum(W / part.density_g_cm3 for part, W in parts)
    fractions: dict[int, float] = {}
    for part, W in parts:
        for Z, w in part.fractions:
            fractions[Z] = fractions.get(Z, 0.0) + W * w
    return Material(name, rho, tuple(sorted(fractions.items())))


def linear_attenuation(material: Material, energies_kev: np.ndarray, *, process: str = "total") -> np.ndarray:
    """mu (n,) in 1/mm at energies (n,) keV; process: total, photoelectric, incoherent or coherent.

    Raises XrayError for an unknown process or energies outside ENERGY_LIMITS_KEV.
    """
    if process not in PROCESSES:
        raise XrayError(f"unknown process {process!r}; choose one of: {', '.join(PROCESSES)}")
    energies = np.atleast_1d(np.asarray(energies_kev, float))
    require_energies(energies)
    mu_over_rho = sum(w * _element(process, Z, energies.tobytes()) for Z, w in material.fractions)  # cm2/g
    return material.density_g_cm3 * np.asarray(mu_over_rho) / MM_PER_CM


def require_energies(energies_kev: np.ndarray) -> None:
    """Raises XrayError when an energy is not finite or outside the cross-section tables in use."""
    low, high = ENERGY_LIMITS_KEV
    if not np.all((energies_kev >= low) & (energies_kev <= high)):
        wrong = energies_kev[~((energies_kev >= low) & (energies_kev <= high))][0]
        raise XrayError(
            f"energy {wrong:g} keV is outside {low:g} to {high:g} keV; mammography uses 5 to 40 keV"
        )


@lru_cache(maxsize=512)
def _element(process: str, Z: int, energies: bytes) -> np.ndarray:
    """mu/rho (n,) in cm2/g of one element; energies (n,) keV as bytes, to be remembered by."""
    return np.array([PROCESSES[process](Z, E) for E in np.frombuffer(energies)])
