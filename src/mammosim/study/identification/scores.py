"""Estimates beside the truth of a digital volunteer: moduli, motion, shape. Only scoring may call this."""

from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.meshing.distance import surface_distance

KEY = ["volunteer", "side", "tissue"]
COLUMNS = ["true_kpa", "fitted_kpa", "low_kpa", "high_kpa", "inside_95", "identifiable"]
SHARE_OF_VOLUNTEERS = 0.9  # of the virtual patients, in which a modulus shall lie in its interval


def scored(fitted: pd.DataFrame, truth: pd.DataFrame, *, seed: int, seconds: float) -> pd.DataFrame:
    """The true modulus beside the fitted one and its 95 % interval: a row per side and tissue.

    fitted: volunteer, side, tissue, fitted_kpa, low_kpa, high_kpa, identifiable; truth: volunteer, side,
    tissue, true_kpa, 0 for what she does not have. inside_95 is empty where no interval is stated.
    Raises ConfigurationError when the two have not the same volunteer, sides and tissues.
    """
    both = truth.merge(fitted, on=KEY, how="outer", indicator=True, validate="one_to_one")
    if (alone := both[both._merge != "both"]).size:
        names = ", ".join(" ".join(row) for row in alone[KEY].values)
        raise ConfigurationError(
            f"fit and truth do not have the same moduli: {names}; fit the volunteer again"
        )
    both = truth[KEY].merge(both, on=KEY)
    inside = ((both.low_kpa <= both.true_kpa) & (both.true_kpa <= both.high_kpa)).astype(object)
    both["inside_95"] = inside.where(np.isfinite(both.low_kpa) & np.isfinite(both.high_kpa), None)
    return both.assign(seed=seed, seconds=seconds)[["seed", *KEY, *COLUMNS, "seconds"]]


def by_tissue(table: pd.DataFrame) -> pd.DataFrame:
    """One row per tissue and side over all volunteers: how often, how narrow and how near.

    table: rows of `scored`. Of the identifiable ones: inside, how many lie in their interval; width_factor,
    median of its upper over its lower end; error_percent, median of |fitted / true - 1|.
    """
    return pd.DataFrame(
        {"tissue": tissue, "side": side, "volunteers": len(rows), **_accuracy(rows[rows.identifiable])}
        for tissue, of_tissue in table.groupby("tissue", sort=False)
        for side, rows in of_tissue.groupby("side", sort=False)
    )


def numbers(table: pd.DataFrame) -> dict[str, Any]:
    """What the page quotes: of all moduli, of each tissue, and of volunteers whose moduli are all inside."""
    found = table[table.identifiable]
    outside = found[found.inside_95 == False]  # noqa: E712, empty where no interval is stated
    volunteers = list(dict.fromkeys(table.volunteer))
    whole = [v for v in volunteers if v not in set(outside.volunteer)]
    sides = by_tissue(table)
    often = sides[sides.identifiable > 0]
    values = {
        "volunteers": len(volunteers),
        "volunteers_all_inside": len(whole),
        "moduli": len(table),
        "moduli_missed": int((sides.inside < SHARE_OF_VOLUNTEERS * sides.identifiable).sum()),
        "moduli_checked": len(often),
        "outside": "; ".join(" ".join(row) for row in outside[KEY].values) or "none",
        "seconds_median": float(table.groupby("volunteer").seconds.first().median()),
        "seconds_max": float(table.seconds.max()),
        **{f"all.{name}": value for name, value in _accuracy(found).items()},
    }
    for tissue in dict.fromkeys(table.tissue):
        accuracy = _accuracy(found[found.tissue == tissue])
        values |= {f"{tissue}.{name}": value for name, value in accuracy.items()}
    return {f"recovery.{name}": value for name, value in values.items()}


def _accuracy(found: pd.DataFrame) -> dict[str, float | int | None]:
    """Of identifiable moduli; None where there are none."""
    n, inside = len(found), int((found.inside_95 == True).sum())  # noqa: E712
    width, error = found.high_kpa / found.low_kpa, (found.fitted_kpa / found.true_kpa - 1).abs()
    return {
        "identifiable": n,
        "inside": inside,
        "inside_percent": 100 * inside / n if n else None,
        "width_factor": float(width.median()) if n else None,
        "error_percent": float(100 * error.median()) if n else None,
    }


def registration_error(
    estimated: RigidTransform, true_moving: RigidTransform, true_fixed: RigidTransform, points: np.ndarray
) -> dict[str, float]:
    """Error of a motion from the moving into the fixed scanner frame, at points (n, 3) of the moving one.

    true_moving, true_fixed: motions from the body frame into each scanner frame. T = fixed o moving^-1;
    rotation_error_deg is the angle of estimated o T^-1, error_*_mm are |estimated(p) - T(p)|.
    """
    true = true_fixed.after(true_moving.inverse())
    distance = np.linalg.norm(estimated(points) - true(points), axis=1)
    return {
        "rotation_error_deg": estimated.after(true.inverse()).angle_deg,
        "error_mean_mm": float(distance.mean()),
        "error_max_mm": float(distance.max()),
        "rotation_true_deg": true.angle_deg,
        "motion_mean_mm": float(np.linalg.norm(true(points) - points, axis=1).mean()),
    }


def shape_error(estimate: TetMesh, truth: TetMesh, *, motion: RigidTransform) -> dict[str, float]:
    """Distance of the estimated skin from the true skin, in mm, over the nodes of the estimate's skin.

    motion: from the body frame, in which the truth is kept, into the frame of the estimate.
    """
    return distances(surface_distance(estimate, truth.moved_to(motion(truth.points))))


def distances(d: np.ndarray) -> dict[str, float]:
    """Mean, 95th percentile and largest of distances (n,) in mm, and how many."""
    return {
        "mean_mm": float(d.mean()),
        "p95_mm": float(np.percentile(d, 95)),
        "max_mm": float(d.max()),
        "nodes": len(d),
    }


def score_row(volunteer: str, what: dict[str, str], error: dict[str, float]) -> pd.DataFrame:
    """A table of one row: volunteer, what was scored (e.g. position or method), and its errors."""
    return pd.DataFrame([{"volunteer": volunteer, **what, **error}])
