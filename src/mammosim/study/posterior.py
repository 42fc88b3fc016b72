"""What a fit says of each modulus: value, 95 % interval, whether the data determine it; and draws."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.rng import generator
from mammosim.mechanics.sides import SIDES
from mammosim.study.fit import Fit
from mammosim.study.identification import MECHANICAL, N_MODULI, Problem
from mammosim.study.moduli import KEYS, Moduli

# Standard deviations to either side of a 95 % interval.
QUANTILE = 1.96
# ASSUME: a modulus counts as identifiable when the data leave at most half of the prior's standard deviation.
IDENTIFIABLE = 0.5
# In the order of every table of moduli.
ROWS = ("adipose", "glandular", "skin", "fascia", "muscle")
# Draws stay within these standard deviations of the prior's mean, where the prior means anything.
WITHIN = 3.0
LARGEST_POISSON_RATIO = 0.4999


def moduli_table(volunteer: str, problem: Problem, fit: Fit, *, fascia_mm: float) -> pd.DataFrame:
    """A row per side and tissue: fitted_kpa, low_kpa, high_kpa, identifiable, reason.

    fascia_mm: the thickness that superficial fascia would have.
    """
    rows = [
        _fascia_row(problem, fit, side, fascia_mm) if tissue == "fascia" else _row(problem, fit, side, tissue)
        for side in SIDES
        for tissue in ROWS
    ]
    return pd.DataFrame(rows).assign(volunteer=volunteer)[["volunteer", *rows[0]]]


def _row(problem: Problem, fit: Fit, side: str, tissue: str) -> dict[str, Any]:
    j = KEYS.index((side, tissue))
    deviation, prior = float(np.sqrt(fit.covariance[j, j])), float(problem.prior.deviation[j])
    E = float(np.exp(fit.state.theta[j]))
    low, high = E * np.exp(-QUANTILE * deviation), E * np.exp(QUANTILE * deviation)
    found = deviation <= IDENTIFIABLE * prior
    share = 100 * deviation / prior
    reason = f"the data leave {share:.0f} % of what was uncertain before"
    if not found:
        reason += ": the interval is mostly what was assumed"
    return _values(side, tissue, E, low, high, found, reason)


# ASSUME: the fit has no fascia of its own; what it has is part of the skin's stiffness.
def _fascia_row(problem: Problem, fit: Fit, side: str, fascia_mm: float) -> dict[str, Any]:
    """Right under the skin and of its law, fascia is seen in E_skin h_skin + E_fascia h_fascia only."""
    skin = _row(problem, fit, side, "skin")
    most = skin["high_kpa"] * float(problem.assumed["skin"]["thickness_mm"]) / fascia_mm
    reason = (
        f"only E h of skin and fascia together is seen; taken as absent, at most this if {fascia_mm:g} mm of "
        "it carried all of the skin's stiffness"
    )
    return _values(side, "fascia", 0.0, 0.0, most, False, reason)


def _values(
    side: str, tissue: str, E: float, low: float, high: float, identifiable: bool, reason: str
) -> dict[str, Any]:
    return {
        "side": side,
        "tissue": tissue,
        "fitted_kpa": E,
        "low_kpa": low,
        "high_kpa": high,
        "identifiable": identifiable,
        "reason": reason,
    }


def draws(problem: Problem, fit: Fit, count: int, *, stream: tuple[str | int, ...]) -> pd.DataFrame:
    """Bodies drawn from the posterior: a row {side}_{tissue}_kpa and poisson_ratio each, row 0 the fit."""
    mean, covariance = fit.state.theta[:MECHANICAL], fit.covariance[:MECHANICAL, :MECHANICAL]
    z = generator(*stream, "posterior").multivariate_normal(mean, covariance, size=count - 1, method="eigh")
    centre, reach = (values[:MECHANICAL] for values in (problem.prior.mean, WITHIN * problem.prior.deviation))
    z = np.vstack([mean, np.clip(z, centre - reach, centre + reach)])
    nu = np.minimum(z[:, N_MODULI], LARGEST_POISSON_RATIO)
    moduli = pd.DataFrame([Moduli.of_logarithms(row[:N_MODULI]).row() for row in z])
    return moduli.assign(poisson_ratio=nu)


def fit_row(volunteer: str, problem: Problem, fit: Fit) -> Mapping[str, Any]:
    """One row about a fit: what is left of the data, what else was fitted, and what it took."""
    last, theta = fit.history[-1], fit.state.theta
    others = dict(zip(("poisson_ratio", *(f"left_{name}" for name in _RIGID)), theta[N_MODULI:]))
    return {
        "volunteer": volunteer,
        "skin_rms_mm": last.skin_rms_mm,
        "marker_rms_mm": last.marker_rms_mm,
        "skin_error_mm": fit.errors.skin_mm,
        "marker_error_mm": fit.errors.marker_mm,
        **others,
        "iterations": len(fit.history) - 1,
        "seconds": fit.seconds,
    }


_RIGID = ("shift_x_mm", "shift_y_mm", "shift_z_mm", "turn_x_deg", "turn_y_deg", "turn_z_deg")
