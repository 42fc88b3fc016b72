"""Glandular tissue of one breast: a seeded random texture that tapers towards the nipple."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from mammosim.core.errors import ConfigurationError
from mammosim.core.rng import generator
from mammosim.digital.patient import Gland
from mammosim.digital.shape import Mound, random_waves, waves

# ASSUME: gland is where random waves on a cone narrowing to the nipple exceed a threshold; no lobes or ducts.
WAVES = 40
LONGEST_WAVE_MM = 40.0
TEXTURE_WEIGHT = 0.8
# ASSUME: within this share of the base radius of the axis, the gland reaches the nipple's skin.
DUCT_SHARE = 0.12


@dataclass(frozen=True)
class GlandField:
    """g(p) = forward s - (rho / (1 - 0.5 s))^2 + 0.8 w(p), gland where g > threshold.

    s: height along the breast's axis as a share of the projection; rho: distance from the axis per base
    radius; w: random waves of variance 1.
    """

    mound: Mound
    cover_mm: float
    k: np.ndarray
    phase: np.ndarray
    forward: float = 0.0
    threshold: float = 0.0

    def parts(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s (n,) and g without its forward term (n,)."""
        q = self.mound.local(points) / self.mound.radii
        s, rho = q[:, 2], np.hypot(q[:, 0], q[:, 1])
        cone = (rho / np.maximum(1 - 0.5 * s, 0.1)) ** 2
        return s, TEXTURE_WEIGHT * waves(points, self.k, self.phase) - cone

    def possible(self, points: np.ndarray, skin_depth: np.ndarray, muscle_distance: np.ndarray) -> np.ndarray:
        """Where gland may be (n,): covered by fat on all sides, save for the ducts behind the nipple."""
        q = self.mound.local(points) / self.mound.radii
        ducts = (np.hypot(q[:, 0], q[:, 1]) < DUCT_SHARE) & (q[:, 2] > 0.5)
        return ((skin_depth > self.cover_mm) | ducts) & (muscle_distance > self.cover_mm)

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) hold gland, where it is possible."""
        s, g = self.parts(points)
        return g + self.forward * s > self.threshold


def gland_field(gland: Gland, mound: Mound, seed: int) -> GlandField:
    """The texture of one breast, before its threshold is known."""
    k, phase = random_waves(generator(seed, "gland", mound.side), WAVES, gland.wave_mm, LONGEST_WAVE_MM)
    return GlandField(mound, gland.cover_mm, k, phase)


def fitted(
    field: GlandField, gland: Gland, points: np.ndarray, possible: np.ndarray, share: Callable
) -> GlandField:
    """The field whose threshold gives the gland fraction and whose forward term gives the share in front.

    points (n, 3): evenly spread over the breast, skin included; possible (n,) bool; share(held (n,) bool) ->
    the part of the held points in the nipple's half. Raises ConfigurationError when the targets do not fit.
    """
    s, g = field.parts(points[possible])
    wanted = gland.fraction * len(points)
    if wanted > 0.95 * len(g):
        raise ConfigurationError(
            f"gland fraction {gland.fraction:g} does not fit under cover_mm = {gland.cover_mm:g}: at most "
            f"{0.95 * len(g) / len(points):.3f} does; lower either"
        )

    def threshold(forward: float) -> float:
        return float(np.quantile(g + forward * s, 1 - wanted / len(g)))

    def front_excess(forward: float) -> float:
        held = np.zeros(len(points), bool)
        held[possible] = g + forward * s > threshold(forward)
        return share(held) - gland.front

    low, high = -20.0, 20.0
    if front_excess(low) > 0 or front_excess(high) < 0:
        raise ConfigurationError(
            f"gland front = {gland.front:g} cannot be reached with fraction {gland.fraction:g}: between "
            f"{front_excess(low) + gland.front:.2f} and {front_excess(high) + gland.front:.2f} is possible"
        )
    forward = float(brentq(front_excess, low, high, xtol=1e-4))
    return GlandField(field.mound, field.cover_mm, field.k, field.phase, forward, threshold(forward))
