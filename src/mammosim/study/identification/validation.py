"""How well a fitted body predicts a measured position; and what a model costs that leaves something out."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import EquilibriumError, FiducialError, MeshError
from mammosim.core.fiducials import Fiducials
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.body import Body
from mammosim.meshing.distance import distance_opposite, distance_to_rim
from mammosim.study.identification.pair import CUT_MM

MOVING = ("breast", "nipple")  # kinds of fiducials that move with the skin
NIPPLES = ("nipple_left", "nipple_right")


@dataclass(frozen=True)
class Start:
    """Where the fit began: a measured position, its fiducials, and the points (n_node, 3) mm free of stress.

    All in one frame; the fiducials are centres of balls on the skin of `mesh`.
    """

    mesh: TetMesh
    fiducials: Fiducials
    stress_free: np.ndarray

    def moving(self, x: np.ndarray) -> Fiducials:
        """Breast markers and nipples when the nodes are at x (n_node, 3), as far off the skin as before."""
        kept = [n for n, kind in enumerate(self.fiducials.kinds) if kind in MOVING]
        given = self.fiducials.points[kept]
        there = MaterialPoints.on(self.mesh, given).carry_above(given, self.mesh.points, x)
        return Fiducials(
            tuple(self.fiducials.names[n] for n in kept), tuple(self.fiducials.kinds[n] for n in kept), there
        )


@dataclass(frozen=True)
class Prediction:
    """points (n_node, 3) mm of a predicted position, NaN when not found; outcome: CONVERGED, or why not."""

    points: np.ndarray
    outcome: str = CONVERGED


def predicted(start: Start, body: Body, gravity: np.ndarray, *, near: np.ndarray | None = None) -> Prediction:
    """The fitted body under gravity (3,), unit vector in its frame.

    A body without equilibrium is an outcome.
    near (n_node, 3): a neighbouring equilibrium to begin from, by default the stress-free shape.
    """
    try:
        state = body.load(start.mesh.moved_to(start.stress_free), gravity, start=near)
    except EquilibriumError as error:
        return Prediction(np.full_like(start.mesh.points, np.nan), unsolved(error))
    return Prediction(state.points)


def point_errors(found: Fiducials, measured: Fiducials) -> dict[str, float]:
    """Distances in mm by quantity: each breast marker and nipple, marker_mean, marker_max.

    Without the markers where one of the lists has none. Raises FiducialError when both have breast markers,
    and share none.
    """
    shared = [name for name in found.names if name in measured.names]
    errors = {name: float(np.linalg.norm(found.point(name) - measured.point(name))) for name in shared}
    markers = [error for name, error in errors.items() if name not in NIPPLES]
    if not all(len(each.of_kind("breast")) for each in (found, measured)):
        return errors
    if not markers:
        raise FiducialError("no breast marker is in both positions' lists; give them the same names")
    return errors | {"marker_mean": float(np.mean(markers)), "marker_max": float(np.max(markers))}


def skin_distances(found: TetMesh, measured: TetMesh) -> np.ndarray:
    """Distances (n,) mm from each node of either skin to the other skin, those that count.

    None over the rim of the other skin, where that was cut, nor within CUT_MM of its own rim.
    Raises MeshError when neither skin lies opposite the other.
    """
    # ASSUME: skin within 20 mm of where a body was cut out of its image does not count in the validation.
    pairs = ((found, measured), (measured, found))
    d = np.concatenate([distance_opposite(one, other) for one, other in pairs])
    counted = d[np.isfinite(d) & (np.concatenate([distance_to_rim(one) for one, _ in pairs]) >= CUT_MM)]
    if len(counted) == 0:
        raise MeshError("the two skins do not lie opposite each other; are both in the common frame?")
    return counted


def skin_errors(found: TetMesh, measured: TetMesh) -> dict[str, float]:
    """skin_mean, skin_p95 and skin_hausdorff of skin_distances, mm."""
    d = skin_distances(found, measured)
    return {
        "skin_mean": float(d.mean()),
        "skin_p95": float(np.percentile(d, 95)),
        "skin_hausdorff": float(d.max()),
    }


def errors(start: Start, x: np.ndarray, measured: TetMesh, fiducials: Fiducials) -> dict[str, float]:
    """point_errors and skin_errors of the shape x (n_node, 3) against a measured position, same frame."""
    return point_errors(start.moving(x), fiducials) | skin_errors(start.mesh.moved_to(x), measured)


def rows(
    job: Mapping[str, str | bool],
    prediction: Prediction,
    *,
    found: Mapping[str, float],
    before: Mapping[str, float],
    published: Mapping[str, float],
) -> pd.DataFrame:
    """Rows of one position: the keys of job, quantity, value_mm, before_mm, published_mm, outcome.

    found: `errors` of the prediction, empty when there is none; before: those of the start itself, unmoved;
    published: of another woman, by quantity. NaN where there is none.
    """
    columns = {
        "value_mm": [found.get(name, np.nan) for name in before],
        "before_mm": list(before.values()),
        "published_mm": [published.get(name, np.nan) for name in before],
    }
    table = pd.DataFrame({"quantity": list(before), **columns})
    for place, (name, value) in enumerate(job.items()):
        table.insert(place, name, value)
    return table.assign(outcome=prediction.outcome)


COMPARED = ["position", "fitted", "quantity"]


def costs(validation: pd.DataFrame, references: Mapping[str, str]) -> pd.DataFrame:
    """woman, reference, COMPARED, right_mm of her reference, wrong_mm of the woman, cost_mm, the difference.

    validation: rows of validation.csv of both; references: woman -> reference volunteer.
    """
    parts = []
    for woman, reference in references.items():
        wrong, right = (
            validation[validation.volunteer == name].set_index(COMPARED).value_mm
            for name in (woman, reference)
        )
        both = pd.DataFrame({"right_mm": right, "wrong_mm": wrong}).reindex(right.index).reset_index()
        both.insert(0, "woman", woman)
        both.insert(1, "reference", reference)
        parts.append(both.assign(cost_mm=both.wrong_mm - both.right_mm))
    return pd.concat(parts, ignore_index=True)


def moduli_beside(moduli: pd.DataFrame, references: Mapping[str, str]) -> pd.DataFrame:
    """woman, reference, side, tissue, right_kpa of the reference, wrong_kpa, and times, their ratio."""
    parts = []
    for woman, reference in references.items():
        wrong, right = (
            moduli[moduli.volunteer == name].set_index(["side", "tissue"]).fitted_kpa
            for name in (woman, reference)
        )
        both = pd.DataFrame({"right_kpa": right, "wrong_kpa": wrong}).reindex(right.index).reset_index()
        both.insert(0, "woman", woman)
        both.insert(1, "reference", reference)
        parts.append(both.assign(times=both.wrong_kpa / both.right_kpa))
    return pd.concat(parts, ignore_index=True)


def wrong_model_numbers(table: pd.DataFrame, moduli: pd.DataFrame) -> dict[str, float | str | None]:
    """wrong_model.* by name, of the first woman: nipple at most, markers, skin, stiffness of fat.

    Errors are those of the positions held out; *_cost_fitted_mm of those that were fitted.
    """
    first = table[table.woman == table.woman.iloc[0]]
    held_out, fitted = first[~first.fitted.astype(bool)], first[first.fitted.astype(bool)]
    found: dict[str, float | str | None] = {
        "woman": first.woman.iloc[0],
        "reference": first.reference.iloc[0],
    }
    for name, quantity in (("nipple", "nipple"), ("marker", "marker_mean"), ("skin", "skin_mean")):
        right, wrong = (_largest(held_out, quantity, column) for column in ("right_mm", "wrong_mm"))
        found |= {
            f"{name}_right_mm": _plain(right),
            f"{name}_wrong_mm": _plain(wrong),
            f"{name}_cost_mm": _plain(wrong - right),
        }
    cost = _largest(fitted, "nipple", "wrong_mm") - _largest(fitted, "nipple", "right_mm")
    fat = moduli[(moduli.woman == first.woman.iloc[0]) & (moduli.tissue == "adipose")].times
    found |= {"nipple_cost_fitted_mm": _plain(cost), "adipose_times": _plain(float(fat.mean()))}
    return {f"wrong_model.{name}": value for name, value in found.items()}


def _largest(rows: pd.DataFrame, quantity: str, column: str) -> float:
    return float(rows[column][rows.quantity.str.startswith(quantity)].max())


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None
