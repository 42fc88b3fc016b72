"""The few numbers by which the study and its strategies of compression are told; None where one is absent."""

from collections.abc import Mapping

import pandas as pd

from mammosim.chain.outcome import CONVERGED
from mammosim.chain.strategies import STANDARD


def headlines(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | str | None]:
    """headline.* by name, each over all volunteers and sides; headline.answer: a paragraph per breast."""
    found: dict[str, float | str | None] = {
        "registration_error_max_mm": _extreme(tables, "registration_error", "error_max_mm", "max"),
        "registration_error_max_deg": _extreme(tables, "registration_error", "rotation_error_deg", "max"),
        "marker_residual_max_mm": _extreme(tables, "registration", "marker_residual_max_mm", "max"),
        "cells_largest": _cells(tables),
        "best_nipple_error_mm": _extreme(tables, "sweep", "nipple_left_mm", "min"),
        "sweep_unsolved": _unsolved(tables, "sweep"),
        **_morph(tables),
        **_ratios(tables),
        "upright_unsolved": _unsolved(tables, "upright"),
        "skin_reduction_max_percent": _skin_reduction(tables),
        "unloading_residual_max_mm": _last_residual(tables),
        "stress_free_error_mean_mm": _best_error(tables),
        "unloading_unsolved": _unsolved(tables, "unloading"),
        "pressure_max_kpa": _extreme(tables, "compression", "peak_pressure_kpa", "max"),
        "penetration_max_mm": _extreme(tables, "compression", "penetration_mm", "max"),
        "force_imbalance_max_percent": _extreme(tables, "compression", "imbalance_percent", "max"),
        "dose_min_mgy": _extreme(tables, "image", "dose_mgy", "min"),
        "dose_max_mgy": _extreme(tables, "image", "dose_mgy", "max"),
        "dose_error_max_percent": _percent(_extreme(tables, "dose", "relative_error", "max")),
        "cnr_min": _extreme(tables, "image", "cnr", "min"),
        "cnr_max": _extreme(tables, "image", "cnr", "max"),
    }
    found |= _held_out(tables) | _intervals(tables)
    found |= numbers_of_strategies(tables["compression"]) if "compression" in tables else dict.fromkeys(NAMES)
    found |= _answers(tables["answer"]) if "answer" in tables else dict.fromkeys(OF_ANSWERS)
    if "segmentation_overlap" in tables:
        smallest = tables["segmentation_overlap"].groupby("tissue").dice.min()
        found |= {f"dice_{tissue}_min": float(dice) for tissue, dice in smallest.items()}
    return {f"headline.{name}": value for name, value in found.items()}


def _extreme(tables: Mapping[str, pd.DataFrame], table: str, column: str, which: str) -> float | None:
    values = tables.get(table, pd.DataFrame()).get(column, pd.Series(dtype=float)).dropna()
    return float(values.agg(which)) if len(values) else None


def _morph(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """How near the morphed skins came, and how much volume the worst cell keeps, over the volunteers."""
    last = {"morph": tables["morph"].groupby("volunteer").last()} if "morph" in tables else {}
    return {
        "morph_mean_mm": _extreme(last, "morph", "mean_mm", "max"),
        "morph_facing_mm": _extreme(last, "morph", "facing_mean_mm", "max"),
        "morph_smallest_J": _extreme(last, "morph", "smallest_J", "min"),
    }


def _ratios(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """How much stiffer fat and gland are under compression than under gravity."""
    rows = tables["moduli_ratio"].set_index("tissue").ratio if "moduli_ratio" in tables else {}
    return {
        f"modulus_ratio_{tissue}": float(rows[tissue]) if tissue in rows else None
        for tissue in ("adipose", "glandular")
    }


def _percent(part: float | None) -> float | None:
    return None if part is None else 100 * part


def _unsolved(tables: Mapping[str, pd.DataFrame], table: str) -> float | None:
    """How many rows of a table have no solution."""
    return float((tables[table].outcome != CONVERGED).sum()) if table in tables else None


def _cells(tables: Mapping[str, pd.DataFrame]) -> float | None:
    if "mesh_quality" not in tables:
        return None
    return float(tables["mesh_quality"].groupby(["volunteer", "position"]).size().max())


def _skin_reduction(tables: Mapping[str, pd.DataFrame]) -> float | None:
    """How much less the nipples move with the stiffest skin than without any, percent, for the most."""
    if "upright" not in tables:
        return None
    rows = tables["upright"].dropna(subset=["from_rest_mm"]).sort_values("skin_kpa")
    ends = rows.groupby("volunteer").from_rest_mm.agg(["first", "last"])
    return float((100 * (1 - ends["last"] / ends["first"])).max()) if len(ends) else None


def _last_residual(tables: Mapping[str, pd.DataFrame]) -> float | None:
    """The largest distance of a skin node, mm, that any method ended with."""
    if "stress_free" not in tables:
        return None
    rows = tables["stress_free"].dropna(subset=["max_mm"]).sort_values("iteration")
    return float(rows.groupby(["volunteer", "method"]).max_mm.last().max()) if len(rows) else None


def _best_error(tables: Mapping[str, pd.DataFrame]) -> float | None:
    """Mean error of the stress-free skin by the best method, mm, of the volunteer where it is largest."""
    if "stress_free_error" not in tables:
        return None
    return float(tables["stress_free_error"].groupby("volunteer").mean_mm.min().max())


def _held_out(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """Largest errors of the predicted positions that no fit saw: nipples, markers, skin."""
    rows = tables.get("validation", pd.DataFrame(columns=["fitted", "quantity", "value_mm", "before_mm"]))
    rows = rows[~rows.fitted.astype(bool)]
    found = {
        f"held_out_{name}_mm": _largest(rows.value_mm[rows.quantity.str.startswith(name)])
        for name in ("nipple", "marker_mean", "skin_mean", "skin_p95", "skin_hausdorff")
    }
    nipples = rows.quantity.str.startswith("nipple")
    return found | {"held_out_nipple_before_mm": _largest(rows.before_mm[nipples])}


def _intervals(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """What the uncertainty of the moduli means at most: of the nipple in mm, of force and dose in percent."""
    rows = tables.get(
        "propagation", pd.DataFrame(columns=["quantity", "fit", "low", "high", "share_percent"])
    )
    of = {name: rows[rows.quantity == name] for name in ("nipple_from_fit_mm", "force_n", "agd_mgy")}
    width = {name: 100 * (group.high - group.low) / group.fit for name, group in of.items()}
    return {
        "propagated_nipple_mm": _largest(of["nipple_from_fit_mm"].high),
        "propagated_force_percent": _largest(width["force_n"]),
        "propagated_dose_percent": _largest(width["agd_mgy"]),
        "propagated_share_percent": _largest(rows.share_percent),
    }


def _largest(values: pd.Series) -> float | None:
    """The largest number, None where there is none."""
    known = values.dropna()
    return float(known.max()) if len(known) else None


OF_ANSWERS = ("answer", "reduction_certain_least_mm", "reduction_possible_most_mm")


def _answers(rows: pd.DataFrame) -> dict[str, float | str | None]:
    """The sentences; by how many mm thickness may rise, the least certain and the most possible one."""
    certain, possible = rows.certain_mm - rows.standard_mm, rows.possible_mm - rows.standard_mm
    return {
        "answer": "\n\n".join(rows.sentence.dropna())
        or "No breast was asked about: name volunteers and sides.",
        "reduction_certain_least_mm": _most(certain.dropna(), -1),
        "reduction_possible_most_mm": _largest(possible),
    }


BREAST = ["volunteer", "side"]
# The columns that they are taken from: rows of missing results alone have their keys and the reason.
OF_STRATEGIES = [
    *(*BREAST, "strategy", "moduli", "force_n", "mean_pressure_kpa", "thickness_mm", "thickness_min_mm"),
    *("thickness_max_mm", "logarithmic_p95"),
]
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
    found = rows[rows.outcome == CONVERGED].reindex(columns=OF_STRATEGIES)
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
