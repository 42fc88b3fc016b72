"""What the uncertainty of fitted moduli means: shapes, nipples and the order of stiffness of drawn bodies."""

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.fiducials import Fiducials
from mammosim.core.mesh import TetMesh
from mammosim.core.progress import progress
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.body import Body
from mammosim.mechanics.unloaded import Unloaded
from mammosim.study.identification.moduli import Materials, Moduli

log = logging.getLogger(__name__)

# The first draw is the fit itself; the others come from its posterior.
FIT = 0
AXES = ("x", "y", "z")


class Unload(Protocol):
    """A way from a measured shape to the stress-free one."""

    def __call__(
        self, measured: TetMesh, body: Body, *, gravity: np.ndarray, start: np.ndarray | None = None
    ) -> Unloaded:
        """The stress-free shape of a body measured under gravity (3,)."""
        ...


def drawn_body(mesh: TetMesh, draw: Mapping[str, float], assumed: Materials) -> Body:
    """The body of a row of posterior.draws; assumed: what the fit takes as known, see Moduli.body."""
    nu, middle = float(draw["poisson_ratio"]), float(draw["middle_mm"])
    return Moduli.of_draw(draw).body(mesh, assumed, middle_mm=middle, poisson_ratio=nu)


@dataclass(frozen=True)
class RepositionedDraw:
    """One draw: rest and x (n_node, 3) mm, stress-free and in the new position, NaN when there is none."""

    rest: np.ndarray
    x: np.ndarray
    outcome: str = CONVERGED


@shared_analysis()
def repositioned(
    measured: TetMesh,
    bodies: Sequence[Body],
    *,
    unload: Unload,
    gravity: np.ndarray,
    new_gravity: np.ndarray,
    rest: np.ndarray,
) -> tuple[RepositionedDraw, ...]:
    """Every body unloaded from the measured shape, then loaded in a new position.

    gravity, new_gravity: unit vectors (3,) in the mesh's frame; rest (n_node, 3): where unloading begins.
    A body that cannot be unloaded or loaded is an outcome.
    """
    return tuple(_one_by_one(measured, bodies, unload, gravity, new_gravity, rest))


def _one_by_one(
    measured: TetMesh,
    bodies: Sequence[Body],
    unload: Unload,
    gravity: np.ndarray,
    new_gravity: np.ndarray,
    near: np.ndarray,
) -> Iterator[RepositionedDraw]:
    """One after the other, each beginning where the first came to rest."""
    moved: np.ndarray | None = None
    for body in progress(bodies, label="draws", total=len(bodies)):
        try:
            rest = _rest(measured, body, unload, gravity, near)
            x = body.load(measured.moved_to(rest), new_gravity, start=moved).points
        except (EquilibriumError, MechanicsError) as error:
            log.info("a draw was not solved: %s", error)
            nowhere = np.full_like(measured.points, np.nan)
            yield RepositionedDraw(nowhere, nowhere, unsolved(error))
        else:
            if moved is None:
                near, moved = rest, x
            yield RepositionedDraw(rest, x)


def _rest(measured: TetMesh, body: Body, unload: Unload, gravity: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The stress-free shape (n_node, 3), from a neighbouring one or, where that leads nowhere, from none."""
    try:
        return unload(measured, body, gravity=gravity, start=near).points
    except (EquilibriumError, MechanicsError) as error:
        log.info("the start is dropped: %s", error)
        return unload(measured, body, gravity=gravity).points


def nipple_table(
    measured: TetMesh, nipples: Mapping[str, np.ndarray], draws: Sequence[RepositionedDraw]
) -> pd.DataFrame:
    """A row per draw and side: draw, side, nipple_x_mm, nipple_y_mm, nipple_z_mm, outcome.

    nipples: side -> point (3,) mm as measured in the shape of the mesh.
    """
    rows = []
    for side, point in nipples.items():
        held = MaterialPoints.on(measured, point[None])
        for number, draw in enumerate(draws):
            place = held.carry_above(point[None], measured.points, draw.x)[0]
            at = {f"nipple_{axis}_mm": value for axis, value in zip(AXES, place)}
            rows.append({"draw": number, "side": side, **at, "outcome": draw.outcome})
    return pd.DataFrame(rows)


def stored_energy(body: Body, rest: TetMesh, x: np.ndarray) -> float:
    """Elastic energy of a body, uJ, whose stress-free mesh is brought to the shape x (n_node, 3)."""
    return float(sum(effect.energy(x) for effect in body.effects(rest)))


# ASSUME: bodies in the fit's compressed shape are as stiff between plates, in order, as their energies there.
def by_stiffness(energies: np.ndarray, count: int) -> np.ndarray:
    """Which of the draws after the fit to press, (count,) numbers: equally spaced ranks, softest to stiffest.

    energies (n_draw,): stored_energy of each draw's body in the shape of the fit between the plates. The
    energy of a compression is stationary in the shape, so that to first order its change with the moduli is
    that in the fit's shape; NaN for a draw without shape.
    Raises MechanicsError when fewer draws than asked for have one.
    """
    order = 1 + np.argsort(energies[1:], kind="stable")
    known = order[np.isfinite(energies[order])]
    if not 1 <= count <= len(known):
        raise MechanicsError(f"{count} draws cannot be pressed: {len(known)} beside the fit have a shape")
    middle = (len(known) - 1) / 2
    places = np.linspace(0, len(known) - 1, count) if count > 1 else np.array([middle])
    return known[np.rint(places).astype(int)]


def expected_share_percent(draws: int) -> float:
    """The share of a distribution, on average, between the least and the greatest of n draws from it.

    100 (n - 1) / (n + 1), whatever the distribution.
    """
    return 100 * (draws - 1) / (draws + 1)


def position_rows(nipples: pd.DataFrame, measured: Fiducials) -> list[dict[str, str | float]]:
    """Rows of propagation.csv for the nipples' coordinates, and for their distance from the fit's.

    nipples: nipple_table of all draws; measured: the fiducials of the position, in the same frame.
    """
    rows = []
    columns = [f"nipple_{axis}_mm" for axis in AXES]
    for side, draws in nipples.groupby("side", sort=False):
        places, there = draws.set_index("draw")[columns], _measured(measured, f"nipple_{side}")
        fit = places.loc[FIT].to_numpy()
        away = np.linalg.norm(places.to_numpy() - fit, axis=1)
        places["nipple_from_fit_mm"] = np.where(places.isna().any(axis=1), np.nan, away)
        found = (*there, float(np.linalg.norm(there - fit)))
        ranked = int(places.drop(index=FIT).notna().all(axis=1).sum())
        rows += [_row(str(side), places[name], ranked, measured=value) for name, value in zip(places, found)]
    return rows


def _measured(measured: Fiducials, name: str) -> np.ndarray:
    """The point (3,), NaN where it was not measured."""
    return measured.point(name) if name in measured.names else np.full(3, np.nan)


def pressed_rows(pressed: pd.DataFrame, *, ranked: int) -> list[dict[str, str | float]]:
    """Rows of propagation.csv for force and dose.

    pressed: side, draw, force_n, agd_mgy of the fit and of the softest to the stiffest of `ranked` draws; a
    side whose fit was not pressed has no rows, and `solved` counts the draws that were.
    """
    return [
        _row(str(side), draws.set_index("draw")[name], ranked)
        for side, draws in pressed.groupby("side", sort=False)
        for name in ("force_n", "agd_mgy")
        if (draws.draw == FIT).any()
    ]


def _row(side: str, values: pd.Series, ranked: int, *, measured: float = np.nan) -> dict[str, str | float]:
    """The value at the fit, least and greatest of values by draw, which span those of `ranked` draws."""
    return {
        "side": side,
        "quantity": str(values.name),
        "fit": float(values[FIT]),
        "low": float(values.min()),
        "high": float(values.max()),
        "measured": float(measured),
        "solved": int(values.notna().sum()),
        "draws": ranked,
        "share_percent": expected_share_percent(ranked),
    }
