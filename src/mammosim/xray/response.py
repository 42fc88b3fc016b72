"""What one photon leaves in a detector: absorption in a layer, and the escape of its K fluorescence.

A photon is absorbed with eta = T_cover (1 - exp(-mu t)). Above the K edge, a share f_K omega_K of the photo-
electric absorptions sends out a photon of E_K, which escapes with P, averaged over the depth z of absorption:

    P = int_0^t mu exp(-mu z) [E2(mu_K z) + E2(mu_K (t - z))]/2 dz / (1 - exp(-mu t))
    E2(x) = int_1^inf exp(-x s)/s^2 ds
    <q> = eta (E - p E_K),   <q^2> = eta [(1 - p) E^2 + p (E - E_K)^2] / A_S,   p = f_K omega_K P
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xraylib
from scipy.special import expn

from mammosim.core.errors import XrayError
from mammosim.io.tabulated import tabulated
from mammosim.xray.attenuation import Material, linear_attenuation, material

DEPTHS = 64  # points of Gauss over the layer: the escape is known to 1e-4


@dataclass(frozen=True)
class Response:
    """A layer that absorbs, its cover, and the Swank factor A_S of its conversion to charge or light.

    Raises XrayError when thicknesses are negative, or the Swank factor is not in (0, 1].
    """

    absorber: Material
    thickness_mm: float
    cover: Material
    cover_mm: float = 0.0
    swank: float = 1.0

    def __post_init__(self) -> None:
        if not (0 < self.thickness_mm < 5 and 0 <= self.cover_mm < 10):
            raise XrayError(
                f"layers of {self.thickness_mm} mm under {self.cover_mm} mm: give mm, usual are 0.2 under 1"
            )
        if not 0 < self.swank <= 1:
            raise XrayError(f"swank = {self.swank} must be in (0, 1]; without noise of conversion it is 1")

    def absorption(self, energies_kev: np.ndarray) -> np.ndarray:
        """eta (n,): the share of photons of each energy that interact in the layer."""
        # ASSUME: a photon crosses cover and layer straight; coherent scattering in the layer does not matter.
        through = np.exp(-linear_attenuation(self.cover, energies_kev) * self.cover_mm)
        eta: np.ndarray = through * (1 - np.exp(-self._mu(energies_kev) * self.thickness_mm))
        return eta

    def moments(self, energies_kev: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """<q> (n,) in keV and <q^2> (n,) in keV2 of photons of each energy, those that pass included."""
        # ASSUME: what is absorbed, and fluorescence that does not escape, counts in the pixel where it fell.
        E, eta = np.asarray(energies_kev, float), self.absorption(energies_kev)
        first, second = E.copy(), E**2
        for Z, edge, share, lines in _fluorescence(self.absorber):
            for E_K, rate in lines:
                p = np.where(edge < E, share * rate * self._photoelectric(Z, E) * self._escape(E, E_K), 0.0)
                first -= p * E_K
                second += p * ((E - E_K) ** 2 - E**2)
        return eta * first, eta * second / self.swank

    def _mu(self, E: np.ndarray) -> np.ndarray:
        """Of all but coherent scattering, 1/mm."""
        total, coherent = (linear_attenuation(self.absorber, E, process=p) for p in ("total", "coherent"))
        mu: np.ndarray = total - coherent
        return mu

    def _photoelectric(self, Z: int, E: np.ndarray) -> np.ndarray:
        """The share of absorptions that is photoelectric in the element Z."""
        w = dict(self.absorber.fractions)[Z]
        alone = Material("element", self.absorber.density_g_cm3, ((Z, 1.0),))
        share: np.ndarray = w * linear_attenuation(alone, E, process="photoelectric") / self._mu(E)
        return share

    def _escape(self, E: np.ndarray, E_K: float) -> np.ndarray:
        """P (n,) of a fluorescent photon of E_K, after absorption of photons of E (n,)."""
        t, mu, mu_K = self.thickness_mm, self._mu(E)[:, None], self._mu(np.array([E_K]))[0]
        s, weight = np.polynomial.legendre.leggauss(DEPTHS)
        z, dz = t * (s + 1) / 2, t / 2 * weight
        leaves = (expn(2, mu_K * z) + expn(2, mu_K * (t - z))) / 2
        P: np.ndarray = (mu * np.exp(-mu * z) * leaves) @ dz / (1 - np.exp(-mu[:, 0] * t))
        return P


def _fluorescence(absorber: Material) -> list[tuple[int, float, float, tuple[tuple[float, float], ...]]]:
    """Of each element with a K edge above 5 keV: Z, edge, f_K omega_K, and its lines (energy, rate)."""
    found = []
    for Z, _ in absorber.fractions:
        edge = xraylib.EdgeEnergy(Z, xraylib.K_SHELL)
        if edge > 5:
            f_K = 1 - 1 / xraylib.JumpFactor(Z, xraylib.K_SHELL)
            lines = tuple(
                (xraylib.LineEnergy(Z, line), xraylib.RadRate(Z, line))
                for line in (xraylib.KA_LINE, xraylib.KB_LINE)
            )
            found.append((Z, edge, f_K * xraylib.FluorYield(Z, xraylib.K_SHELL), lines))
    return found


def response_of(detector: str) -> Response:
    """The response of a detector of the table `image_detectors`. Raises XrayError when it has none such."""
    row = detector_row(detector)
    return Response(
        material(row["absorber"]), row["thickness_mm"], material(row["cover"]), row["cover_mm"], row["swank"]
    )


def detector_row(detector: str) -> dict[str, Any]:
    """A row of the table `image_detectors`. Raises XrayError when it has no such detector."""
    rows: dict[str, dict[str, Any]] = {
        row["detector"]: row for row in tabulated("image_detectors").to_dict("records")
    }
    if detector not in rows:
        raise XrayError(f"unknown detector {detector!r}; choose one of: {', '.join(rows)}")
    return rows[detector]
