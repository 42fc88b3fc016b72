"""X-ray spectra, their half-value layer and air kerma.

Air kerma K = sum_j N_j E_j (mu_en/rho)(E_j); behind a half-value layer of x mm aluminium, K(x) = K(0)/2.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from mammosim.core.errors import XrayError
from mammosim.core.units import G_PER_KG, J_PER_KEV, MGY_PER_GY, MM_PER_CM
from mammosim.io.tabulated import tabulated
from mammosim.xray.attenuation import Material, linear_attenuation, material, require_energies


@dataclass(frozen=True)
class Spectrum:
    """Photons of an X-ray beam in vacuum, without air.

    energies_kev: (n,) increasing.
    fluence: (n,) photons per mm2 and mAs at `distance_mm` from the source, perpendicular to the beam.
    name: what made it, for tables and messages.

    Raises XrayError when shapes differ, energies fall, or fluence is negative, not finite or zero everywhere.
    """

    energies_kev: np.ndarray
    fluence: np.ndarray
    distance_mm: float = 1000.0
    name: str = ""

    def __post_init__(self) -> None:
        require_energies(self.energies_kev)
        if self.energies_kev.shape != self.fluence.shape or self.energies_kev.ndim != 1:
            raise XrayError(
                f"energies {self.energies_kev.shape} and fluence {self.fluence.shape} must both be (n,)"
            )
        if np.any(np.diff(self.energies_kev) <= 0):
            raise XrayError("energies of a spectrum must increase")
        if not (np.all(self.fluence >= 0) and 0 < self.fluence.sum() < np.inf):
            raise XrayError("fluence of a spectrum must be finite and not negative, with at least one photon")
        if not 0 < self.distance_mm < np.inf:
            raise XrayError(f"distance_mm = {self.distance_mm} must be positive")

    @property
    def mean_energy_kev(self) -> float:
        """E = sum_j N_j E_j / sum_j N_j."""
        return float(self.fluence @ self.energies_kev / self.fluence.sum())

    @property
    def kerma_mgy_per_mas(self) -> float:
        """Air kerma at `distance_mm`, in vacuum."""
        return float(self.fluence @ kerma_per_fluence(self.energies_kev))

    @property
    def hvl_mm_al(self) -> float:
        """First half-value layer."""
        return value_layer(self, fraction=0.5)

    def through(self, matter: Material, thickness_mm: float) -> "Spectrum":
        """The narrow beam behind a layer: N exp(-mu t)."""
        transmitted = np.exp(-linear_attenuation(matter, self.energies_kev) * thickness_mm)
        return replace(self, fluence=self.fluence * transmitted)

    def at(self, distance_mm: float) -> "Spectrum":
        """The same beam at another distance: N (d/d')^2, in vacuum."""
        return replace(
            self, fluence=self.fluence * (self.distance_mm / distance_mm) ** 2, distance_mm=distance_mm
        )

    def rebinned(self, count: int) -> "Spectrum":
        """At most `count` energies; each group of bins keeps its number of photons and its energy."""
        E, N = self.energies_kev, self.fluence
        edges = np.linspace(E[0], E[-1], count + 1)
        group = np.clip(np.searchsorted(edges, E, side="right") - 1, 0, count - 1)
        photons = np.bincount(group, N, minlength=count)
        energy = np.bincount(group, N * E, minlength=count)
        some = photons > 0
        return replace(self, energies_kev=energy[some] / photons[some], fluence=photons[some])


def kerma_per_fluence(energies_kev: np.ndarray) -> np.ndarray:
    """Air kerma (n,) in mGy for one photon per mm2 of each energy: E mu_en/rho, log-log in the table.

    Raises XrayError for energies outside the table `air_energy_absorption`.
    """
    table = tabulated("air_energy_absorption")
    E, mu_en = table["energy_kev"].to_numpy(), table["mu_en_over_rho_cm2_g"].to_numpy()
    if not np.all((energies_kev >= E[0]) & (energies_kev <= E[-1])):
        raise XrayError(f"air kerma is tabulated from {E[0]} to {E[-1]} keV; the spectrum goes beyond")
    cm2_g = np.exp(np.interp(np.log(energies_kev), np.log(E), np.log(mu_en)))
    kerma: np.ndarray = energies_kev * J_PER_KEV * cm2_g * MM_PER_CM**2 * G_PER_KG * MGY_PER_GY
    return kerma


def value_layer(spectrum: Spectrum, *, fraction: float) -> float:
    """Aluminium in mm that leaves `fraction` of the air kerma: 0.5 for the half-value layer, 0.25 for two."""
    mu = linear_attenuation(material("aluminium"), spectrum.energies_kev)
    K = spectrum.fluence * kerma_per_fluence(spectrum.energies_kev)
    return float(brentq(lambda x: K @ np.exp(-mu * x) / K.sum() - fraction, 0.0, 200.0, xtol=1e-9))


def monoenergetic(energy_kev: float, *, fluence: float = 1.0, distance_mm: float = 1000.0) -> Spectrum:
    """One energy, energy_kev; `fluence` photons per mm2 and mAs at `distance_mm` from the source.

    Returns a spectrum of one line. Raises XrayError for an energy or fluence that is not above 0.
    """
    return Spectrum(np.array([energy_kev]), np.array([fluence]), distance_mm, f"{energy_kev:g} keV")
