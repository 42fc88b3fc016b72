"""Compression of a body between two plates that approach each other, and the way back."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from mammosim.core.errors import EquilibriumError, MechanicsError, OutOfBudget
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.analysis import system_of
from mammosim.mechanics.budget import BudgetSpent, Spending
from mammosim.mechanics.effects import (
    ContactState,
    Effect,
    RigidPlate,
    Weight,
    six_points_in_each,
)
from mammosim.mechanics.equilibrium import LARGEST_IMBALANCE, Equilibrium, held_nodes, solve
from mammosim.mechanics.friction_state import FrictionState
from mammosim.mechanics.newton import StepFailed
from mammosim.mechanics.paddles import Plates
from mammosim.mechanics.potential import Potential, energy_imbalance
from mammosim.mechanics.press import Press
from mammosim.mechanics.press_path import WarmStart, force_n, path_table
from mammosim.mechanics.reference import faces_of, require_well_posed
from mammosim.mechanics.rigid_motions import require_held
from mammosim.mechanics.stage import Control, Force, PressSettings, Stage, Thickness, default_penalty

__all__ = ["Compression", "Force", "PressSettings", "Thickness", "compress", "continued", "released"]

log = logging.getLogger(__name__)

# Contact takes many rough steps of Newton, so that the V-cycle pays from fewer unknowns on (same note).
MULTIGRID_ABOVE = 5_000
_MOST_TRIALS = 20
# How far beyond first contact the plates part, relative to the way: where flat skin is just in contact, which
# points do is left to rounding.
_CLEARANCE = 0.01


@dataclass(frozen=True)
class Compression:
    """points (n_node, 3) mm; stages: the way there; plates and contacts: paddle and support at the end.

    equilibrium: of the last step; between: the plates as they were asked for.
    path: one row per step: thickness_mm (between the faces at their middle), readout_mm (before the paddle
    yields), force_n (of the skin on the paddle along the axis), support_force_n, chest_force_n (on the body
    by held nodes, chest wall and weight, so that the first is the sum of the others), contact_area_mm2 and
    mean_pressure_kpa of the paddle, peak_pressure_kpa (largest mean of a face over its part in contact),
    penalty_kpa_per_mm, penetration_mm, tilt_deg, deflection_mm (largest of the faces from flat ones),
    energy_uj (of body, contact, cushions and paddle), dissipated_uj (by friction), smallest_J, iterations (of
    Newton), seconds, work_uj (of the plates, by trapezoids).
    """

    points: np.ndarray
    path: pd.DataFrame
    equilibrium: Equilibrium
    plates: tuple[RigidPlate, RigidPlate]
    contacts: tuple[ContactState, ContactState]
    stages: tuple[Stage, ...]
    between: Plates

    def gap(self, points: np.ndarray) -> np.ndarray:
        """Distance between the faces of the plates at points (n, 3), (n,) mm; NaN beside the plates.

        Cushions yield as far as they do at the nearest place where skin is in contact.
        """
        gap = self.between.gap(points, self.stages[-1].thickness, self.stages[-1].q)
        for contact in self.plates:
            if contact.cushion is not None:
                gap = gap + self._yielded(contact, points)
        return gap

    def _yielded(self, contact: RigidPlate, points: np.ndarray) -> np.ndarray:
        """How far the cushion of a plate yields at points (n, 3), (n,) mm, 0 where no skin is on it."""
        y, yielded = contact.indentation(self.points)
        if len(y) == 0:
            return np.zeros(len(points))
        P = self.between.axes[:, :2]
        away, nearest = cKDTree(y @ P).query(points @ P)
        # A point of contact stands for what is nearer than the middle of its face is.
        reach = np.sqrt(contact.areas.max())
        return np.where(away < reach, yielded[nearest], 0.0)

    def room(self, points: np.ndarray) -> tuple[float, float]:
        """How far paddle and support are beyond flat ones over points (n, 3) of the skin at most, mm.

        See Plates.room; cushions yield as far as anywhere.
        """
        room = self.between.room(points, self.stages[-1].thickness, self.stages[-1].q)
        paddle, support = (
            float(contact.indentation(self.points)[1].max(initial=0.0)) for contact in self.plates
        )
        return room[0] + paddle, room[1] + support


def compress(
    mesh: TetMesh,
    effects: tuple[Effect, ...],
    *,
    plates: Plates,
    control: Control,
    held: np.ndarray | None = None,
    settings: PressSettings | None = None,
) -> Compression:
    """Press a body, whose mesh.points are stress-free, between the plates to a thickness or a force.

    control: `Thickness`, mm, or `Force`, N; settings: steps, penetration, solver.
    Returns the shape (n_node, 3) mm, a row per step, and plates and contacts at the end.
    The plates start at first contact with the body, and approach symmetrically; a step that fails is halved.
    effects may hold more than tissue and skin: weight, under which the body is at the start, and a chest
    wall. held (n_node, 3) bool, default all components of the nodes of `posterior`.
    Raises MechanicsError when the asked thickness is not below that of first contact, EquilibriumError when
    no verified equilibrium was reached, or not the force; its message names what was.
    """
    settings = settings or PressSettings()
    plates.require_possible(control.mm if isinstance(control, Thickness) else None)
    with _press(mesh, effects, plates, held, settings) as press:
        return _compression(press, mesh, _to_control(press, [_first_stage(press, mesh)], control))


def continued(
    mesh: TetMesh,
    effects: tuple[Effect, ...],
    *,
    plates: Plates,
    control: Control,
    warm_starts: Sequence[WarmStart],
    held: np.ndarray | None = None,
    settings: PressSettings | None = None,
) -> Compression:
    """As compress, along the load path of another compression of the same body, by a rigid paddle.

    warm_starts: its stages from first contact on; those beyond the control are left out. plates: at the
    same place, a paddle that yields at rest; held: as in compress. Raises MechanicsError with friction or
    without a stage, else as compress.
    """
    if plates.friction is not None or not warm_starts:
        raise MechanicsError(
            "a compression is continued without friction, from one warm start or more; use compress instead"
        )
    with _press(mesh, effects, plates, held, settings or PressSettings()) as press:
        return _compression(
            press, mesh, _to_control(press, [each.stage(press) for each in warm_starts], control)
        )


def released(
    mesh: TetMesh,
    effects: tuple[Effect, ...],
    compression: Compression,
    *,
    held: np.ndarray | None = None,
    settings: PressSettings | None = None,
) -> Compression:
    """The way back of a compression of the same body: the plates part until contact ends.

    Raises EquilibriumError as compress does.
    """
    settings = settings or PressSettings()
    with _press(mesh, effects, compression.between, held, settings) as press:
        there = list(compression.stages)
        began, ended = there[0].thickness, there[-1].thickness
        stages = _to_thickness(press, there, began + _CLEARANCE * (began - ended))
        return _compression(press, mesh, stages[len(compression.stages) - 1 :])


@contextmanager
def _press(
    mesh: TetMesh,
    effects: tuple[Effect, ...],
    plates: Plates,
    held: np.ndarray | None,
    settings: PressSettings,
) -> Iterator[Press]:
    held = held_nodes(mesh) if held is None and "posterior" in mesh.boundaries else held
    held = require_well_posed(mesh, held)
    faces = faces_of(mesh, "skin")
    rule = six_points_in_each(settings.parts)
    penalty = settings.penalty_kpa_per_mm or default_penalty(effects)
    areas = rule.areas(mesh.points, faces)
    boxes = plates.at(1e3 * float(np.ptp(mesh.points)))
    paddle, support = (
        RigidPlate(faces, areas, box, penalty, rule, cushion) for box, cushion in zip(boxes, plates.cushions)
    )
    with system_of(Potential((*effects, paddle, support)), held, MULTIGRID_ABOVE) as system:
        if plates.friction is None:
            require_held(system, effects, mesh.points, pressed_along=plates.axes[:, 2])
        system = replace(system, spending=Spending(settings.solver.budget))
        try:
            yield Press(system, effects, (paddle, support), plates, settings)
        except BudgetSpent as spent:
            raise OutOfBudget(f"the last step of the compression: {spent}", best=spent.x) from spent
        except StepFailed as failure:
            raise EquilibriumError(
                f"the last step of the compression failed: {failure}; use more steps, or a finer mesh"
            ) from failure


def _first_stage(press: Press, mesh: TetMesh) -> Stage:
    """The body under its weight, if it has any, and the plates at first contact with it."""
    weights = tuple(effect for effect in press.effects if isinstance(effect, Weight))
    x = mesh.points
    if weights:
        rest = tuple(effect for effect in press.effects if not isinstance(effect, Weight))
        x = solve(replace(press.system, potential=Potential((*rest, *press.apart), weights)), x).points
    thickness = press.plates.first_contact(x[np.unique(press.apart[0].faces)])
    boxes = press.plates.at(thickness)
    paddle, support = (replace(contact, obstacle=box) for contact, box in zip(press.apart, boxes))
    law = press.plates.friction
    friction_states = (
        () if law is None else tuple(FrictionState.none(law, contact) for contact in (paddle, support))
    )
    return Stage(thickness, press.plates.at_rest, x, (paddle, support), friction_states)


def _to_control(press: Press, stages: list[Stage], control: Control) -> list[Stage]:
    """The stages, those beyond the control left out, and those that follow up to it."""
    if isinstance(control, Force):
        return _to_force(press, stages, control)
    goal = _within(control.mm, stages[0].thickness)
    return _to_thickness(press, [stage for stage in stages if stage.thickness > goal], goal)


def _within(thickness: float, contact: float) -> float:
    if not 0 < thickness < contact:
        raise MechanicsError(
            f"thickness {thickness:g} mm is outside (0, {contact:.1f}), the first contact of the plates"
        )
    return thickness


def _to_thickness(
    press: Press, stages: list[Stage], target: float, enough: Callable[[Stage], bool] = lambda stage: False
) -> list[Stage]:
    """The stages, and those that follow up to a thickness, or until one is enough."""
    stages = list(stages)
    way = target - stages[-1].thickness
    whole = np.ptp([target, *(stage.thickness for stage in stages)])
    step = largest = float(whole) / press.settings.steps
    failures: list[str] = []
    while stages[-1].thickness != target and not enough(stages[-1]):
        left = abs(target - stages[-1].thickness)
        # In a longer step skin might come nearer to the side of a plate than to its face.
        if stages[-1].meets_an_edge(step):
            step = min(step, *(contact.obstacle.radius for contact in stages[-1].contacts))
        goal = target if left <= 1.2 * step else stages[-1].thickness + np.copysign(step, way)
        try:
            stages.append(press.pressed(stages, goal, on_the_way=goal != target))
        except BudgetSpent as spent:
            raise _out_of_budget(press, target, stages, spent, failures) from spent
        except (StepFailed, EquilibriumError) as error:
            step = min(step, left) / 2
            log.info("compression to %.2f mm failed, halving the step: %s", goal, error)
            failures.append(str(error))
            if step < press.settings.smallest_step_mm:
                raise _stopped(press, target, stages, error) from error
        else:
            failures.clear()
            step = min(2 * step, largest)
    return stages


def _stopped(press: Press, target: float, stages: list[Stage], error: Exception) -> EquilibriumError:
    return EquilibriumError(
        f"{_reached(press, target, stages)}: {error}; a finer mesh, a larger edge radius of the plates, or "
        "skin may carry it further",
        history=tuple(row for stage in stages for row in stage.history),
    )


def _reached(press: Press, target: float, stages: list[Stage]) -> str:
    force = force_n(stages[-1], press.plates.axes[:, 2])
    return f"compression to {target:g} mm stopped at {stages[-1].thickness:.2f} mm and {force:.3g} N"


def _out_of_budget(
    press: Press, target: float, stages: list[Stage], spent: BudgetSpent, failures: list[str]
) -> OutOfBudget:
    tried = "".join(f", the one before: {failure}" for failure in failures[-1:])
    return OutOfBudget(
        f"{_reached(press, target, stages)}: {spent}{tried}; a finer mesh, a larger edge radius of the "
        "plates, skin, or a larger Settings.budget may carry it further",
        history=tuple(row for stage in stages for row in stage.history),
        best=spent.x,
    )


def _to_force(press: Press, stages: list[Stage], control: Force) -> list[Stage]:
    """The stages up to a force: steps until it is exceeded, then a secant that stays between its bounds."""
    axis, target = press.plates.axes[:, 2], control.newton
    smallest = _within(control.smallest_mm, stages[0].thickness)

    def reached(stage: Stage) -> bool:
        return force_n(stage, axis) >= target

    below = list(takewhile(lambda stage: not reached(stage), stages))
    stages = _around(press, stages[: len(below) + 1], smallest, reached)
    above, forces = stages[-1], [force_n(stage, axis) for stage in stages]
    if forces[-1] < target * (1 - control.tolerance):
        raise EquilibriumError(
            f"at the smallest thickness, {smallest:g} mm, the force is {forces[-1]:.3g} N, less than "
            f"{target:g} N: ask for a smaller force, or allow a smaller thickness"
        )
    low, high = (stages[-2].thickness, forces[-2]), (above.thickness, forces[-1])
    stages, last = stages[:-1], (low, high)
    for _ in range(_MOST_TRIALS):
        if abs(high[1] / target - 1) <= control.tolerance:
            return [*stages, above]
        goal = _between(low, high, last, target)
        trial = press.pressed([above, stages[-1]], goal)
        found = (goal, force_n(trial, axis))
        last = (last[1], found)
        if abs(found[1] / target - 1) <= control.tolerance:
            return [*stages, trial]
        low, high = (found, high) if found[1] < target else (low, found)
    raise EquilibriumError(f"{_MOST_TRIALS} trials did not meet {target:g} N: {low}, {high} mm and N")


def _around(
    press: Press, stages: list[Stage], smallest: float, reached: Callable[[Stage], bool]
) -> list[Stage]:
    """The stages up to the first that has reached something; it and the one before settled."""
    while True:
        stages = _to_thickness(press, stages, smallest, reached)
        stages = [*stages[:-2], press.settled(stages[:-1]), press.settled(stages)]
        if reached(stages[-1]) or stages[-1].thickness == smallest:
            break
    while reached(stages[-2]):
        stages = [*stages[:-3], press.settled(stages[:-2]), stages[-2]]
    return stages


Tried = tuple[float, float]


def _between(low: Tried, high: Tried, last: tuple[Tried, Tried], target: float) -> float:
    """The thickness where the line through the last two trials has the force, kept between the bounds."""
    (t0, f0), (t1, f1) = last
    goal = t1 + (target - f1) * (t1 - t0) / (f1 - f0) if f1 != f0 else np.inf
    inside = min(low[0], high[0]) < goal < max(low[0], high[0])
    return goal if inside else (low[0] + high[0]) / 2


def _compression(press: Press, mesh: TetMesh, stages: list[Stage]) -> Compression:
    """The verified result of stages."""
    before, last = stages[-2], press.finished(stages[-1])
    stages = [*stages[:-1], last]
    potential = Potential((*press.effects, *last.surroundings()))
    system = replace(press.system, potential=potential)
    state = solve(system, mesh.points, start=last.x, settings=press.settings.solver)
    imbalance = energy_imbalance(potential, [before.x, last.x])
    if imbalance > LARGEST_IMBALANCE:
        raise EquilibriumError(
            f"the energy of the last step is off by {imbalance:.1e}, at most {LARGEST_IMBALANCE:g}: use more "
            "steps",
            history=last.history,
        )
    state = replace(state, energy_imbalance=imbalance, history=last.history)
    for contact in last.contacts:
        contact.require_cushion(last.x)
    contacts = tuple(contact.state(last.x) for contact in last.contacts)
    return Compression(
        last.x,
        path_table(press, stages),
        state,
        last.contacts,
        (contacts[0], contacts[1]),
        tuple(stages),
        press.plates,
    )
