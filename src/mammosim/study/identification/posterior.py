"""What a fit says of each modulus: value, 95 % interval, whether the data determine it; and draws."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from mammosim.chain.quantities import QUANTILE
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.tissues import WITH_MODULUS
from mammosim.mechanics.body import SIDES
from mammosim.mechanics.ligaments import faces_between
from mammosim.mechanics.reference import cell_quadrature, face_quadrature
from mammosim.study.identification.fit import Fit
from mammosim.study.identification.moduli import KEYS, Moduli
from mammosim.study.identification.problem import MECHANICAL, N_MODULI, OTHERS, Problem

# ASSUME: a modulus counts as identifiable when the data leave at most half of the prior's standard deviation.
IDENTIFIABLE = 0.5
UNRESOLVED = (
    "the layer is thinner than two elements, whose cells hold fat as well; in series, the fat gives way and "
    "hides what the muscle does: nothing is known but what was assumed"
)
# Draws stay within these standard deviations of the prior's mean, where the prior means anything.
WITHIN = 3.0
LARGEST_POISSON_RATIO = 0.4999


class ModulusRow(NamedTuple):
    """What a fit says of one modulus, kPa; low and high: ends of the 95 % interval."""

    side: str
    tissue: str
    fitted_kpa: float
    low_kpa: float
    high_kpa: float
    identifiable: bool
    reason: str


def moduli_table(volunteer: str, problem: Problem, fit: Fit, *, fascia_mm: float) -> pd.DataFrame:
    """A row per side and tissue: fitted_kpa, low_kpa, high_kpa, identifiable, reason.

    fascia_mm: the thickness that superficial fascia would have.
    """
    rows = [
        _fascia_row(problem, fit, side, fascia_mm) if tissue == "fascia" else _row(problem, fit, side, tissue)
        for side in SIDES
        for tissue in WITH_MODULUS
    ]
    table = pd.DataFrame(rows)
    table.insert(0, "volunteer", volunteer)
    return table


def covariance(problem: Problem, fit: Fit) -> np.ndarray:
    """(15, 15) of theta: of the data and the prior, and of ln E that of the model, alike on both sides."""
    total = fit.covariance.copy()
    for tissue, deviation in problem.model_error.items():
        own = [j for j, key in enumerate(KEYS) if key[1] == tissue]
        total[np.ix_(own, own)] += deviation**2
    return total


def _row(problem: Problem, fit: Fit, side: str, tissue: str) -> ModulusRow:
    j = KEYS.index((side, tissue))
    deviation, prior = float(np.sqrt(covariance(problem, fit)[j, j])), float(problem.prior.deviation[j])
    E = float(np.exp(fit.state.theta[j]))
    low, high = E * np.exp(-QUANTILE * deviation), E * np.exp(QUANTILE * deviation)
    if tissue == "muscle" and not is_resolved(problem.pair.start.mesh, Label.MUSCLE):
        median, most = problem.prior.median_kpa[tissue], problem.prior.factor[tissue] ** QUANTILE
        low, high = min(low, median / most), max(high, median * most)
        return ModulusRow(side, tissue, E, low, high, False, UNRESOLVED)
    found = deviation <= IDENTIFIABLE * prior
    reason = f"{100 * deviation / prior:.0f} % of what was uncertain before is left"
    if not found:
        reason += ": the interval is mostly what was assumed"
    return ModulusRow(side, tissue, E, low, high, found, reason)


def is_resolved(mesh: TetMesh, label: Label) -> bool:
    """Whether a layer of a tissue is at least as thick as two of its elements; true where there is none.

    Its thickness is V / A, A the faces that it shares with others; the edge of a regular element of volume v
    is (6 sqrt(2) v)^(1/3).
    """
    cells = mesh.tissue == label
    faces = faces_between(mesh, label)
    if not cells.any() or len(faces) == 0:
        return True
    volumes = cell_quadrature(mesh.points, mesh.cells[cells]).volumes.sum(axis=1)
    area = face_quadrature(mesh.points, faces).areas.sum()
    edge = (6 * np.sqrt(2) * volumes.mean()) ** (1 / 3)
    return bool(volumes.sum() / area >= 2 * edge)


# ASSUME: the fit has no fascia of its own; what it has is part of the skin's stiffness.
def _fascia_row(problem: Problem, fit: Fit, side: str, fascia_mm: float) -> ModulusRow:
    """Right under the skin and of its law, fascia is seen in E_skin h_skin + E_fascia h_fascia only."""
    skin = _row(problem, fit, side, "skin")
    most = skin.high_kpa * float(problem.assumed.skin.thickness_mm) / fascia_mm
    reason = (
        f"only E h of skin and fascia together is seen; taken as absent, at most this if {fascia_mm:g} mm of "
        "it carried all of the skin's stiffness"
    )
    return ModulusRow(side, "fascia", 0.0, 0.0, most, False, reason)


def draws(problem: Problem, fit: Fit, count: int, *, stream: tuple[str | int, ...]) -> pd.DataFrame:
    """Bodies drawn from the posterior: a row {side}_{tissue}_kpa and poisson_ratio each, row 0 the fit.

    middle_mm: x of the plane between the sides, the same in each row.
    """
    mean, spread = fit.state.theta[:MECHANICAL], covariance(problem, fit)[:MECHANICAL, :MECHANICAL]
    z = generator(*stream, "posterior").multivariate_normal(mean, spread, size=count - 1, method="eigh")
    centre, reach = (values[:MECHANICAL] for values in (problem.prior.mean, WITHIN * problem.prior.deviation))
    z = np.vstack([mean, np.clip(z, centre - reach, centre + reach)])
    nu = np.minimum(z[:, N_MODULI], LARGEST_POISSON_RATIO)
    moduli = pd.DataFrame([Moduli.of_logarithms(row[:N_MODULI]).row() for row in z])
    return moduli.assign(poisson_ratio=nu, middle_mm=problem.middle_mm)


def fit_row(volunteer: str, problem: Problem, fit: Fit) -> dict[str, str | float]:
    """One row about a fit: what is left of the data, what else was fitted, and what it took."""
    last, theta = fit.history[-1], fit.state.theta
    others = dict(zip(OTHERS, theta[N_MODULI:]))
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
