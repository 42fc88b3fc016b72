"""Bodies of other laws than the hyperelastic one: in small increments, and as a network of springs.

Small increments: the load is brought on in n equal parts, each by linear elasticity on the shape that the
last one left, whose stress and its part of the load balance, so that neither enters:

    K(x_i) (x_(i+1) - x_i) = f / n        under dead loads
    K(x_i) (x_(i+1) - x_i) + f_i = contact,  f_(i+1) = f_i + K(x_i) (x_(i+1) - x_i)        between plates
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.units import MN_PER_N
from mammosim.mechanics.body import Body
from mammosim.mechanics.effects import (
    Effect,
    RigidPlate,
    SmallStrain,
    SpringNetwork,
    Weight,
    six_points_in_each,
)
from mammosim.mechanics.equilibrium import Equilibrium, Settings, equilibrium
from mammosim.mechanics.paddles import Plates
from mammosim.mechanics.reference import faces_of
from mammosim.mechanics.stage import PENALTY_RATIO, PressSettings

# Contact opens and closes, as in mechanics.compression; what an increment leaves, the next one does not see.
_BETWEEN_PLATES = Settings(
    newton=replace(PressSettings().solver.newton, tolerance=PressSettings().path_tolerance)
)


@dataclass(frozen=True)
class NetworkBody(Body):
    """A body whose bulk is a network of springs, see effects.SpringNetwork."""

    def bulk(self, mesh: TetMesh) -> Effect:
        """The springs of a mesh whose points are the reference."""
        return SpringNetwork.of(mesh, self.tissues)


@dataclass(frozen=True)
class IncrementalBody(Body):
    """A body in small increments, each without stress at its beginning.

    increments: of every load; free_under (3,): the gravity under which the reference is, by assumption, free
    of stress, so that another one acts by its difference; None for none. Raises MechanicsError for no
    increment.
    """

    increments: int = 10
    free_under: np.ndarray | None = None

    def __post_init__(self) -> None:
        if self.increments < 1:
            raise MechanicsError(f"increments = {self.increments} must be 1 or more; try 10")

    def bulk(self, mesh: TetMesh) -> Effect:
        """Linear elasticity in one increment, on a mesh whose points are where it begins."""
        return SmallStrain.of(mesh, self.tissues)

    def load(
        self,
        mesh: TetMesh,
        gravity: np.ndarray,
        *,
        start: np.ndarray | None = None,
        settings: Settings | None = None,
    ) -> Equilibrium:
        """The last of the equilibria of all increments, the first from rest: a start is not used."""
        f = self.weight(mesh, gravity).forces
        if self.free_under is not None:
            f = f - self.weight(mesh, self.free_under).forces
        held, x = self.held(mesh), mesh.points
        for _ in range(self.increments):
            here = mesh.moved_to(x)
            part = Weight(x, f / self.increments)
            found = equilibrium(here, self.effects(here), loads=(part,), held=held, settings=settings)
            x = found.points
        return found


def pressed_in_increments(
    mesh: TetMesh, body: IncrementalBody, *, plates: Plates, thickness_mm: float
) -> pd.DataFrame:
    """A body pressed by rigid plates from first contact to a thickness, in its increments.

    mesh: free of stress. A row per increment: thickness_mm, force_n of the paddle, penetration_mm.
    Raises MechanicsError where first contact is nearer, or an increment has no equilibrium.
    """
    faces, rule = faces_of(mesh, "skin"), six_points_in_each(PressSettings().parts)
    first = plates.first_contact(mesh.points[np.unique(faces)])
    if thickness_mm >= first:
        raise MechanicsError(
            f"thickness {thickness_mm:g} mm is not below {first:.1f} mm, where the plates first meet the body"
        )
    penalty = PENALTY_RATIO * float(np.median(SmallStrain.of(mesh, body.tissues).mu))
    areas, held = rule.areas(mesh.points, faces), body.held(mesh)
    x, inner, rows = mesh.points, np.zeros_like(mesh.points), []
    for goal in np.linspace(first, thickness_mm, body.increments + 1)[1:]:
        here = mesh.moved_to(x)
        effects = body.effects(here)
        paddle, support = (RigidPlate(faces, areas, box, penalty, rule) for box in plates.at(float(goal)))
        carried = Weight(x, -inner)
        acting = (*effects, carried, paddle, support)
        try:
            x = equilibrium(here, acting, held=held, settings=_BETWEEN_PLATES).points
        except MechanicsError as failure:
            raise MechanicsError(
                f"the increment to {goal:.1f} mm between the plates has no equilibrium: {failure}"
            ) from failure
        for effect in effects:
            effect.add_gradient(x, inner)
        rows.append(_row(float(goal), paddle, plates, x))
    return pd.DataFrame(rows)


def _row(goal: float, paddle: RigidPlate, plates: Plates, x: np.ndarray) -> dict[str, float]:
    g = np.zeros_like(x)
    paddle.add_gradient(x, g)
    force = abs(float(g.sum(axis=0) @ plates.axes[:, 2])) / MN_PER_N
    return {"thickness_mm": goal, "force_n": force, "penetration_mm": paddle.state(x).penetration}


def in_increments(body: Body, increments: int, free_under: np.ndarray | None) -> IncrementalBody:
    """The same tissues and parts in small increments."""
    return IncrementalBody(body.tissues, body.parts, increments, free_under)


def as_network(body: Body) -> NetworkBody:
    """The same tissues and parts, the bulk a network of springs."""
    return replace(NetworkBody(body.tissues), parts=body.parts)
