"""The search by hand: one modulus for fat and gland, one for skin, and what each pair of them leaves."""

import numpy as np
import pandas as pd

from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.core.errors import EquilibriumError
from mammosim.core.progress import progress
from mammosim.mechanics.analysis import shared_analysis
from mammosim.study.identification.fit import left_over
from mammosim.study.identification.moduli import KEYS
from mammosim.study.identification.problem import Problem
from mammosim.study.identification.settings import Grid


@shared_analysis()
def grid_table(problem: Problem, grid: Grid) -> pd.DataFrame:
    """A row per pair: breast_kpa (fat and gland, both sides), skin_kpa, skin_rms_mm, marker_rms_mm, outcome.

    Everything else as the prior's mean. A pair without equilibrium has no numbers but a reason.
    """
    pairs = [(breast, skin) for breast in grid.breast_kpa for skin in grid.skin_kpa]
    return pd.DataFrame(_row(problem, *pair) for pair in progress(pairs, label="grid", total=len(pairs)))


def _row(problem: Problem, breast: float, skin: float) -> dict[str, float | str]:
    theta = problem.prior.mean.copy()
    for j, (_, tissue) in enumerate(KEYS):
        if tissue != "muscle":
            theta[j] = np.log(skin if tissue == "skin" else breast)
    moduli: dict[str, float | str] = {"breast_kpa": breast, "skin_kpa": skin}
    try:
        state = problem.predicted(theta)
    except EquilibriumError as error:
        return moduli | {"skin_rms_mm": np.nan, "marker_rms_mm": np.nan, "outcome": unsolved(error)}
    skin_rms, marker_rms = left_over(problem, state)
    return moduli | {"skin_rms_mm": skin_rms, "marker_rms_mm": marker_rms, "outcome": CONVERGED}
