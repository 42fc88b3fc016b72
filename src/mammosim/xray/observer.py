"""How well a signal stands out of an image, and how well an observer tells two kinds of images apart: d'.

An observer sees an image through p channels, v = U^T g. With the means of both kinds and their common
covariance S of n1 + n0 - 2 degrees of freedom, and D2 = dv^T S^-1 dv,

    F = n1 n0/(n1 + n0) (n1 + n0 - p - 1)/(p (n1 + n0 - 2)) D2

is noncentral F with p, n1 + n0 - p - 1 degrees of freedom and noncentrality n1 n0/(n1 + n0) d'^2 (Hotelling):
the interval holds all d' for which the F seen is not in a tail. One channel, the expected difference of the
means, makes the non-prewhitening observer; several make the channelised Hotelling observer.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import eval_laguerre

from mammosim.core.errors import XrayError


@dataclass(frozen=True)
class Contrast:
    """Contrast-to-noise ratio, its standard error, and the means and standard deviation it is made of."""

    cnr: float
    standard_error: float
    signal_mean: float
    background_mean: float
    background_std: float


def cnr(image: np.ndarray, signal_mask: np.ndarray, background_mask: np.ndarray) -> Contrast:
    """CNR = |m_s - m_b| / s_b: means over signal and background pixels, standard deviation of the latter.

    Variance to first order, with independent pixels: 1/n_s (s_s/s_b)^2 + 1/n_b + CNR^2 / (2 (n_b - 1)).
    image: (nv, nu); masks: (nv, nu) bool, disjoint.
    Raises XrayError when masks overlap, do not fit, hold fewer than 2 pixels, or the background is flat.
    """
    # ASSUME: noise is that of the background's pixels, so that its structure counts as noise, too.
    _require_masks(image, signal_mask, background_mask)
    s, b = image[signal_mask].astype(float), image[background_mask].astype(float)
    s_b = b.std(ddof=1)
    if s_b == 0:
        raise XrayError("the background is flat, so that CNR is infinite; expose the image with noise first")
    value = abs(s.mean() - b.mean()) / s_b
    variance = (s.std(ddof=1) / s_b) ** 2 / s.size + 1 / b.size + value**2 / (2 * (b.size - 1))
    return Contrast(float(value), float(np.sqrt(variance)), float(s.mean()), float(b.mean()), float(s_b))


def _require_masks(image: np.ndarray, signal_mask: np.ndarray, background_mask: np.ndarray) -> None:
    if not image.shape == signal_mask.shape == background_mask.shape:
        raise XrayError(
            f"image {image.shape}, signal {signal_mask.shape} and background {background_mask.shape} differ"
        )
    if np.any(signal_mask & background_mask):
        raise XrayError("signal and background overlap; take the background around the signal")
    if min(np.count_nonzero(signal_mask), np.count_nonzero(background_mask)) < 2:
        raise XrayError("signal and background need at least 2 pixels each")


@dataclass(frozen=True)
class Detectability:
    """d' without the bias of a finite number of images, and its confidence interval."""

    d: float
    low: float
    high: float


def detectability(
    present: np.ndarray, absent: np.ndarray, channels: np.ndarray, *, confidence: float = 0.95
) -> Detectability:
    """d' from images with (n1, nv, nu) and without (n0, nv, nu) a signal, through channels (p, nv, nu).

    Raises XrayError when shapes differ, or there are no more images than channels and two.
    """
    # ASSUME: what the channels see is normal, with the same covariance with and without the signal.
    if not present.shape[1:] == absent.shape[1:] == channels.shape[1:]:
        raise XrayError(f"images {present.shape}, {absent.shape} and channels {channels.shape} do not match")
    (n1, n0), p = (len(present), len(absent)), len(channels)
    nu = n1 + n0 - p - 1
    if min(n1, n0) < 2 or nu < 2:
        raise XrayError(f"{n1} and {n0} images are too few for {p} channels; make more")
    v1, v0 = (np.tensordot(g.astype(float), channels, ((1, 2), (1, 2))) for g in (present, absent))
    S = sum((len(v) - 1) * np.atleast_2d(np.cov(v.T)) for v in (v1, v0)) / (n1 + n0 - 2)
    dv = v1.mean(axis=0) - v0.mean(axis=0)
    D2 = float(dv @ np.linalg.solve(S, dv))
    per_d2 = n1 * n0 / (n1 + n0)
    F = per_d2 * nu / (p * (n1 + n0 - 2)) * D2
    unbiased = max((nu - 2) / (n1 + n0 - 2) * D2 - p / per_d2, 0.0)
    tail = (1 - confidence) / 2
    low, high = (_where(F, p, nu, per_d2, share) for share in (1 - tail, tail))
    return Detectability(float(np.sqrt(unbiased)), low, high)


def expected_d(present: tuple[float, float], absent: tuple[float, float]) -> float:
    """d' of one channel from its mean and variance with and without the signal, d'^2 = dv^2 / (S1 + S0) 2."""
    (v1, S1), (v0, S0) = present, absent
    return float(abs(v1 - v0) / np.sqrt((S1 + S0) / 2))


def _where(F: float, p: int, nu: int, per_d2: float, share: float) -> float:
    """The d' at which a share of all F lies below the one seen; zero when it is less for every d'."""
    from scipy.stats import ncf  # here, since it takes a third of a second that most stages need not

    def excess(d: float) -> float:
        return float(ncf.cdf(F, p, nu, per_d2 * d**2)) - share

    if excess(0.0) <= 0:
        return 0.0
    high = 1.0
    while excess(high) > 0:
        high *= 2
    return float(brentq(excess, 0.0, high, xtol=1e-4))


def laguerre_gauss(shape: tuple[int, int], *, width_pixels: float, count: int) -> np.ndarray:
    """Channels (count, nv, nu) around the middle: L_n(2 pi r^2/a^2) exp(-pi r^2/a^2), a = width_pixels.

    They see every smooth, round signal (Gallas & Barrett 2003, J Opt Soc Am A 20:1725).
    Raises XrayError when there is no channel, or no width.
    """
    if count < 1 or not width_pixels > 0:
        raise XrayError(f"{count} channels of {width_pixels} pixels: give at least one, wider than zero")
    rows, columns = np.indices(shape)
    r2 = (rows - (shape[0] - 1) / 2) ** 2 + (columns - (shape[1] - 1) / 2) ** 2
    x = np.pi * r2 / width_pixels**2
    return np.array([eval_laguerre(n, 2 * x) * np.exp(-x) for n in range(count)])
