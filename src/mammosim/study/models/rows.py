"""The row of one model: where it puts the nipple in each position, what it takes, and why it failed.

nipple_{position}_mm is the distance from where the nipple was measured in that position; NaN where it was not
measured there. nipple_{position}_{x,y,z}_mm are its place in the common frame.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.graph import Chain
from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.points import MaterialPoints
from mammosim.chain.published import Squeezed
from mammosim.core.errors import ConfigurationError
from mammosim.core.marks import literal
from mammosim.core.mesh import TetMesh

POSITIONS = ("prone", "supine", "upright")
AXES = "xyz"
DIGITS = 6  # of a distance in mm: what is less is rounding


def measured_row(chain: Chain, nipples: Mapping[str, np.ndarray], *, took: float = 0.0) -> dict[str, Any]:
    """nipple_*, stress_free_moved_mm, thickness_mm, force_n, seconds and outcome of the chain of a model.

    nipples: position -> (3,) mm where the nipple was measured, common frame; stress_free_moved_mm: of the
    nipple, from prone to the stress-free shape; took: processor seconds of the products of the study that it
    begins with. The outcome has every reason. Raises ConfigurationError where a setting cannot be meant.
    """
    failures: dict[str, str] = {}

    def made(name: str, doing: str, of: Chain) -> Any:
        product = of.make(name)
        if isinstance(product.failure, ConfigurationError):
            raise product.failure
        if product.failure is not None:
            failures.setdefault(" ".join(unsolved(product.failure).split()), doing)
        return product.value

    mesh: TetMesh = chain["mesh"]
    breast: Breast = chain["breast"]
    hanging = breast.to_reference(breast.nipple[None])
    nipple = MaterialPoints.on(mesh, hanging)

    def nipple_in(points: np.ndarray) -> np.ndarray:
        place: np.ndarray = nipple.carry_above(hanging, mesh.points, points)[0]
        return place

    rest = made("stress_free", "stress-free shape", chain)
    row: dict[str, Any] = {"stress_free_moved_mm": np.nan}
    if rest is not None:
        moved = float(np.linalg.norm(nipple_in(rest.mesh.points) - hanging[0]))
        row["stress_free_moved_mm"] = round(moved, DIGITS)
    for position in POSITIONS:
        found = made("loaded", position, chain.with_settings({"load.position": position}))
        place = np.full(3, np.nan) if found is None else nipple_in(found.mesh.points)
        row |= _placed(position, place, nipples)
    squeezed: Squeezed | None = made("force", "between the plates", chain)
    row |= {
        "thickness_mm": squeezed.thickness_mm if squeezed else np.nan,
        "force_n": squeezed.force_n if squeezed else np.nan,
        "seconds": took + sum(each.seconds for each in chain.made.values()),
    }
    return row | {"outcome": "; ".join(f"{doing} {why}" for why, doing in failures.items()) or CONVERGED}


def _placed(position: str, place: np.ndarray, nipples: Mapping[str, np.ndarray]) -> dict[str, float]:
    away = np.linalg.norm(place - nipples[position]) if position in nipples else np.nan
    at = {f"nipple_{position}_{axis}_mm": float(value) for axis, value in zip(AXES, place)}
    return {f"nipple_{position}_mm": round(float(away), DIGITS), **at}


SCORED = ("stress_free_mean_mm", "stress_free_median_mm", "nipple_upright_mm")
SHOWN = (
    *("volunteer", "side", "model", "title", "law", "moduli_kpa", "skin", "chest", "unloading"),
    *("nipple_prone_mm", "nipple_supine_mm", "nipple_upright_mm", "stress_free_moved_mm"),
    *("stress_free_mean_mm", "stress_free_median_mm", "thickness_mm", "force_n", "seconds", "outcome"),
    *("known_from", "reproduced", "not_reproduced"),
)


def table(rows: pd.DataFrame, scores: pd.DataFrame | None) -> pd.DataFrame:
    """SHOWN, a row per model. rows: of measured_row with the words of a model; scores: SCORED by model, of a
    digital volunteer, whose nipple upright is known by its truth alone.
    """
    if scores is None or scores.empty:
        return rows.assign(**dict.fromkeys(SCORED, np.nan))[list(SHOWN)]
    found = rows.drop(columns="nipple_upright_mm").merge(scores[["model", *SCORED]], on="model", how="left")
    return found[list(SHOWN)]


def numbers(found: pd.DataFrame) -> dict[str, Any]:
    """What the page says: how many found all, nearest and farthest supine nipple, range of force."""
    supine, force = found.dropna(subset="nipple_supine_mm"), found.dropna(subset="force_n")
    near = supine.sort_values("nipple_supine_mm")
    values: dict[str, Any] = {
        "total": len(found),
        "converged": int((found.outcome == CONVERGED).sum()),
        "failed": ", ".join(map(literal, found.title[found.outcome != CONVERGED])) or "none",
        "nearest": literal(near.title.iloc[0]) if len(near) else None,
        "nearest_mm": float(near.nipple_supine_mm.iloc[0]) if len(near) else None,
        "farthest": literal(near.title.iloc[-1]) if len(near) else None,
        "farthest_mm": float(near.nipple_supine_mm.iloc[-1]) if len(near) else None,
        "force_least_n": float(force.force_n.min()) if len(force) else None,
        "force_most_n": float(force.force_n.max()) if len(force) else None,
        "thickness_mm": float(force.thickness_mm.iloc[0]) if len(force) else None,
        "seconds": float(found.seconds.sum()),
    }
    return {f"models.{name}": value for name, value in values.items()}
