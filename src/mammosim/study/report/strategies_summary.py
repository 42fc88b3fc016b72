"""The few numbers by which the strategies of compression are told."""

import pandas as pd

from mammosim.chain.outcome import CONVERGED
from mammosim.chain.strategies import STANDARD

BREAST = ["volunteer", "side"]
NAMES = (
    *("standard_force_least_n", "standard_force_most_n", "moduli_force_ratio", "standard_pressure_most_kpa"),
    *("reduced_thicker_percent", "reduced_strain_percent", "unlevel_most_mm", "strategies_unsolved"),
)


def numbers_of_strategies(rows: pd.DataFrame) -> dict[str, float | None]:
    """Over all breasts, from the rows of compression.csv; None of what no row tells.

    standard_force_least_n, standard_force_most_n: of the standard strategy, with the softest and with the
    stiffest moduli; moduli_force_ratio: of these for one breast, the largest; standard_pressure_most_kpa:
    mean; reduced_thicker_percent, reduced_strain_percent: by how much at most half the force (the strategy
    `reduced`) leaves a breast thicker, and its strain (95 % of the tissue have less) smaller, than the
    standard; unlevel_most_mm: the largest difference of thickness under one paddle; strategies_unsolved.
    """
    found = rows[rows.outcome == CONVERGED]
    standard = found[found.strategy == STANDARD]
    force = standard.groupby(BREAST).force_n.agg(["min", "max"])
    beside = found.merge(standard, on=[*BREAST, "moduli"], suffixes=("", "_standard"))
    reduced = beside[beside.strategy == "reduced"]
    return {
        "standard_force_least_n": _most(standard.force_n, -1),
        "standard_force_most_n": _most(standard.force_n),
        "moduli_force_ratio": _most(force["max"] / force["min"]),
        "standard_pressure_most_kpa": _most(standard.mean_pressure_kpa),
        "reduced_thicker_percent": _most(100 * (reduced.thickness_mm / reduced.thickness_mm_standard - 1)),
        "reduced_strain_percent": _most(
            100 * (1 - reduced.logarithmic_p95 / reduced.logarithmic_p95_standard)
        ),
        "unlevel_most_mm": _most(found.thickness_max_mm - found.thickness_min_mm),
        "strategies_unsolved": float((rows.outcome != CONVERGED).sum()),
    }


def _most(values: pd.Series, sign: int = 1) -> float | None:
    """The largest value, or with sign -1 the smallest."""
    return sign * float((sign * values).max()) if len(values) else None
