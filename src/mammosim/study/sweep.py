"""One position from another by reverse gravity: the elasticity sweep, upright with and without skin."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import EquilibriumError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.body import Skin, load
from mammosim.mechanics.reference import smallest_jacobians


@dataclass(frozen=True)
class Repositioned:
    """A body brought from one position to another.

    points: (n_node, 3) mm in the new position and rest (n_node, 3) in between, both NaN when there is none.
    iterations: of Newton; seconds; smallest_J: of the two equilibria, NaN when there is none.
    outcome: CONVERGED, or why no verified equilibrium was found.
    """

    points: np.ndarray
    rest: np.ndarray
    iterations: int
    seconds: float
    smallest_J: float
    outcome: str


def one_law(
    youngs_modulus_kpa: float, *, poisson_ratio: float, muscle_kpa: float, density_g_cm3: float
) -> dict[Label, Tissue]:
    """One tissue for gland, fat and skin, and a muscle of its own modulus."""
    # ASSUME: in the sweep, gland, fat and skin follow one law with one modulus; only muscle has its own.
    breast = Tissue(youngs_modulus_kpa, poisson_ratio, density_g_cm3)
    muscle = Tissue(muscle_kpa, poisson_ratio, density_g_cm3)
    soft = (Label.ADIPOSE, Label.GLANDULAR, Label.SKIN, Label.LESION)
    return {**dict.fromkeys(soft, breast), Label.MUSCLE: muscle}


@shared_analysis()
def reposition(
    measured: TetMesh,
    tissues: Mapping[Label, Tissue],
    *,
    gravity: np.ndarray,
    new_gravity: np.ndarray,
    skin: Skin | None = None,
) -> Repositioned:
    """Unload a measured shape by reverse gravity, then load it in the new position.

    gravity, new_gravity: unit vectors (3,) in the mesh's frame. A body without equilibrium is an outcome.
    """
    nowhere = np.full_like(measured.points, np.nan)
    doing, iterations, seconds = "unloading", 0, 0.0
    try:
        rest = load(measured, tissues, -np.asarray(gravity), skin=skin)
        iterations, seconds = len(rest.history), rest.seconds
        _require_sound(rest.points, measured.cells)
        doing = "loading the unloaded shape"
        moved = load(measured.moved_to(rest.points), tissues, new_gravity, skin=skin)
    except EquilibriumError as error:
        iterations += len(error.history)
        return Repositioned(nowhere, nowhere, iterations, seconds, np.nan, unsolved(error, doing))
    return Repositioned(
        moved.points,
        rest.points,
        iterations + len(moved.history),
        seconds + moved.seconds,
        min(rest.smallest_J, moved.smallest_J),
        CONVERGED,
    )


def _require_sound(rest: np.ndarray, cells: np.ndarray) -> None:
    """Raises EquilibriumError for a shape that is no reference to load again."""
    inverted = int(np.sum(smallest_jacobians(rest, cells) <= 0))
    if inverted:
        raise EquilibriumError(f"{inverted} cells of the unloaded shape are inverted; raise the modulus")


def sweep_row(
    volunteer: str,
    tissues: Mapping[Label, Tissue],
    measured: TetMesh,
    repositioned: Repositioned,
    *,
    nipples: np.ndarray,
    goal: np.ndarray,
) -> dict[str, str | float]:
    """How near the predicted nipples come: a row of table 1.2 of Mira 2018, NaN where it was not found.

    nipples, goal: left and right nipple (2, 3) mm as measured in the first and in the new position, in
    the frame of the mesh. nipple_*_mm: predicted to measured; supine_*_mm: before any modelling;
    max_displacement_mm: the largest distance of a node between the measured and the predicted shape.
    """
    predicted = MaterialPoints.on(measured, nipples).carry(repositioned.points)
    left, right = np.linalg.norm(predicted - goal, axis=1)
    supine_left, supine_right = np.linalg.norm(nipples - goal, axis=1)
    return {
        "volunteer": volunteer,
        "youngs_modulus_kpa": tissues[Label.ADIPOSE].youngs_modulus_kpa,
        "nipple_left_mm": left,
        "nipple_right_mm": right,
        "max_displacement_mm": largest_displacement(measured.points, repositioned.points),
        "supine_left_mm": supine_left,
        "supine_right_mm": supine_right,
        **_how(repositioned),
    }


def upright_row(
    volunteer: str,
    tissues: Mapping[Label, Tissue],
    measured: TetMesh,
    repositioned: Repositioned,
    *,
    nipples: np.ndarray,
    skin: Skin | None = None,
) -> dict[str, str | float]:
    """How far the body moves from prone to upright, skin_kpa 0 without skin; NaN where it was not found.

    nipples: left and right (2, 3) mm as measured, in the frame of the mesh.
    """
    held = MaterialPoints.on(measured, nipples)
    left, right = np.linalg.norm(held.carry(repositioned.points) - held.carry(measured.points), axis=1)
    return {
        "volunteer": volunteer,
        "youngs_modulus_kpa": tissues[Label.ADIPOSE].youngs_modulus_kpa,
        "skin_kpa": skin.youngs_modulus_kpa if skin else 0.0,
        "nipple_left_displacement_mm": left,
        "nipple_right_displacement_mm": right,
        "max_displacement_mm": largest_displacement(measured.points, repositioned.points),
        "from_rest_mm": largest_displacement(repositioned.rest, repositioned.points),
        **_how(repositioned),
    }


def largest_displacement(before: np.ndarray, after: np.ndarray) -> float:
    """max |x - X| over the nodes, mm; NaN when a shape is missing."""
    return float(np.max(np.linalg.norm(after - before, axis=1)))


def _how(repositioned: Repositioned) -> dict[str, str | float]:
    return {
        "smallest_J": repositioned.smallest_J,
        "iterations": repositioned.iterations,
        "seconds": repositioned.seconds,
        "outcome": repositioned.outcome,
    }
