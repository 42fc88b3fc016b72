"""How well a signal stands out of an image."""

from dataclasses import dataclass

import numpy as np

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
