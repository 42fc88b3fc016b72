"""The few numbers by which the whole study is told, from its tables; None where one is absent."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from mammosim.study.sweep import VERIFIED


def headlines(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """headline.* by name, each over all volunteers and sides."""
    found = {
        "registration_error_max_mm": _extreme(tables, "registration_error", "error_max_mm", "max"),
        "registration_error_max_deg": _extreme(tables, "registration_error", "rotation_error_deg", "max"),
        "marker_residual_max_mm": _extreme(tables, "registration", "marker_residual_max_mm", "max"),
        "cells_largest": _cells(tables),
        "best_nipple_error_mm": _extreme(tables, "sweep", "nipple_left_mm", "min"),
        "sweep_refused": _refused(tables, "sweep"),
        "upright_refused": _refused(tables, "upright"),
        "skin_reduction_max_percent": _skin_reduction(tables),
        "fixed_point_residual_mean_mm": _last_residual(tables, "mean_mm"),
        "fixed_point_residual_max_mm": _last_residual(tables, "max_mm"),
        "stress_free_error_mean_mm": _extreme(tables, "stress_free_error", "mean_mm", "max"),
        "force_max_n": _extreme(tables, "compression", "force_n", "max"),
        "pressure_max_kpa": _extreme(tables, "compression", "peak_pressure_kpa", "max"),
        "penetration_max_mm": _extreme(tables, "compression", "penetration_mm", "max"),
        "dose_min_mgy": _extreme(tables, "image", "dose_mgy", "min"),
        "dose_max_mgy": _extreme(tables, "image", "dose_mgy", "max"),
        "dose_error_max_percent": _percent(_extreme(tables, "dose", "relative_error", "max")),
        "cnr_min": _extreme(tables, "image", "cnr", "min"),
        "cnr_max": _extreme(tables, "image", "cnr", "max"),
    }
    found |= _held_out(tables) | _intervals(tables)
    if "segmentation_overlap" in tables:
        smallest = tables["segmentation_overlap"].groupby("tissue").dice.min()
        found |= {f"dice_{tissue}_min": float(dice) for tissue, dice in smallest.items()}
    return {f"headline.{name}": value for name, value in found.items()}


def _extreme(tables: Mapping[str, pd.DataFrame], table: str, column: str, which: str) -> float | None:
    if table not in tables or tables[table][column].isna().all():
        return None
    return float(tables[table][column].agg(which))


def _percent(part: float | None) -> float | None:
    return None if part is None else 100 * part


def _refused(tables: Mapping[str, pd.DataFrame], table: str) -> float | None:
    return float((tables[table].outcome != VERIFIED).sum()) if table in tables else None


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


def _last_residual(tables: Mapping[str, pd.DataFrame], column: str) -> float | None:
    """The largest residual that any fixed point ended with."""
    if "stress_free" not in tables:
        return None
    rows = tables["stress_free"].query("method == 'fixed_point'").sort_values("iteration")
    return float(rows.groupby("volunteer")[column].last().max()) if len(rows) else None


def _held_out(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """Errors of the predicted positions that no fit saw: the largest nipple and the skin's."""
    if "validation" not in tables:
        return {}
    rows = tables["validation"][~tables["validation"].fitted]
    found = {
        f"held_out_{name}_mm": rows[rows.quantity.str.startswith(name)].value_mm.max()
        for name in ("nipple", "marker_mean", "skin_mean", "skin_p95", "skin_hausdorff")
    }
    before = rows[rows.quantity.str.startswith("nipple")].before_mm.max()
    return {name: _number(value) for name, value in (found | {"held_out_nipple_before_mm": before}).items()}


def _intervals(tables: Mapping[str, pd.DataFrame]) -> dict[str, float | None]:
    """What the uncertainty of the moduli means at most: of the nipple in mm, of force and dose in percent."""
    if "propagation" not in tables:
        return {}
    rows = tables["propagation"].set_index("quantity")
    width = 100 * (rows.high - rows.low) / rows.fit
    return {
        "propagated_nipple_mm": _number(rows.high.get("nipple_from_fit_mm", np.nan)),
        "propagated_force_percent": _number(width.get("force_n", np.nan)),
        "propagated_dose_percent": _number(width.get("agd_mgy", np.nan)),
        "propagated_share_percent": _number(rows.share_percent),
    }


def _number(values: pd.Series | float) -> float | None:
    """The largest, None where there is none."""
    largest = float(np.max(values))
    return largest if np.isfinite(largest) else None
