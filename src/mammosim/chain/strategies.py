"""Strategies of compression: which paddle presses, and until when."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
import pandas as pd

from mammosim.chain.touch import path_of
from mammosim.core.errors import ConfigurationError, MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.compression import Compression, PressSettings, compress, continued
from mammosim.mechanics.effects import Effect
from mammosim.mechanics.paddles import Flexible, Paddle, Plates, Rigid, Tilting
from mammosim.mechanics.press_path import WarmStart
from mammosim.mechanics.stage import Control, Force, Thickness

STANDARD = "standard"
# A force, and a mean pressure, are met within these parts of them.
FORCE_TOLERANCE, PRESSURE_TOLERANCE = 1e-3, 0.02
# A paddle that yields leaves the load path of the rigid one at this part of the force that it is to reach; in
# longer steps the tissue may slip out toward the chest, to a state that never reaches it.
YIELDS_FROM, YIELDING_STEPS = 0.5, 16
# On a mesh the area of contact grows in jumps: where one passes the pressure, the plates stop this near it.
JUMP_MM = 0.5
Step = tuple[float, float]  # distance of the plates in mm, and mean pressure there in kPa

PADDLES: Mapping[str, Callable[..., Paddle]] = {"tilting": Tilting, "flexible": Flexible}


class NoStandard(MechanicsError):
    """A strategy is measured by the standard one, which found no equilibrium."""


@dataclass(frozen=True)
class PressSetup:
    """One breast to press.

    mesh: stress-free; plates: where a rigid paddle would stand; moduli: the name of the set in the effects;
    thickness_mm: of the standard strategy; smallest_mm: no paddle goes further; standard: the load path of
    the standard strategy of the same breast and moduli, None while that is what is to be found; solved: how a
    rigid paddle's path is.
    """

    mesh: TetMesh
    effects: tuple[Effect, ...]
    plates: Plates
    moduli: str
    thickness_mm: float
    smallest_mm: float
    standard: "LoadPath | None" = None
    solved: PressSettings = field(default_factory=PressSettings)

    def pressed(self, paddle: Paddle, control: Control) -> Compression:
        """The breast between support and paddle; raises as mechanics.compression.compress.

        Every paddle follows the load path of the standard strategy, as far as that is known and of use: the
        path of one that yields begins where it leaves it, and has no work. Area and pressures: chain.touch.
        """
        body, plates = (self.mesh, self.effects), replace(self.plates, paddle=paddle)
        settings = self.solved if paddle == Rigid() else replace(self.solved, steps=YIELDING_STEPS)
        # Friction depends on its own load path, and cannot go on with another.
        known = self.standard if self.plates.friction is None else None
        begun = known.begun(paddle, control) if known else ()
        if not begun:
            found = compress(*body, plates=plates, control=control, settings=settings)
            return replace(found, path=path_of(found))
        found = continued(*body, plates=plates, control=control, begun=begun, settings=settings)
        path = path_of(found)
        if paddle != Rigid():
            path = path.iloc[len(begun) :].assign(work_uj=np.nan)
        return replace(found, path=path)

    def standard_path(self) -> pd.DataFrame:
        """Of the standard strategy. Raises NoStandard where that is not known."""
        if not self.standard:
            raise NoStandard("the standard strategy, which this one is measured by, found no equilibrium")
        return self.standard.path


@dataclass(frozen=True)
class LoadPath:
    """The steps of a compression: path of mechanics.compression.Compression; shapes (n_step, n_node, 3) mm.

    mesh: in the last of them.
    """

    path: pd.DataFrame
    shapes: np.ndarray
    mesh: TetMesh

    @classmethod
    def of(cls, mesh: TetMesh, found: Compression) -> "LoadPath":
        """Of a compression of a mesh."""
        return cls(found.path, np.array([stage.x for stage in found.stages]), mesh.moved_to(found.points))

    @staticmethod
    def names(count: int) -> list[str]:
        """What the shapes of so many steps are called in a file."""
        return [f"step_{number:02d}" for number in range(count)]

    def point_data(self) -> dict[str, np.ndarray]:
        """The shapes by their names."""
        return dict(zip(self.names(len(self.shapes)), self.shapes, strict=True))

    def begun(self, paddle: Paddle, control: Control) -> tuple[WarmStart, ...]:
        """Its stages that a paddle can begin with: one that yields, of less than half the force."""
        path = self.path
        if paddle != Rigid():
            below = (
                path.force_n < YIELDS_FROM * control.newton if isinstance(control, Force) else path.index < 0
            )
            path = path[below]
        steps = zip(path.readout_mm, path.penalty_kpa_per_mm, self.shapes)
        return tuple(WarmStart(float(thickness), float(penalty), x) for thickness, penalty, x in steps)


class StoppingCriterion(Protocol):
    """When a paddle stops."""

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """The breast where it stops. Raises MechanicsError (or EquilibriumError) where it cannot."""
        ...


@dataclass(frozen=True)
class ThicknessShare:
    """At a share of the standard strategy's thickness."""

    share: float

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion."""
        goal = self.share * setup.thickness_mm
        if goal < setup.smallest_mm:
            raise MechanicsError(
                f"{goal:g} mm are less than compression.smallest_mm = {setup.smallest_mm:g}, the least "
                "that a strategy may press to: raise its thickness_share"
            )
        return setup.pressed(paddle, Thickness(goal))


@dataclass(frozen=True)
class ForceShare:
    """At a share of the force that the standard strategy takes of the same breast and moduli."""

    share: float

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion."""
        newton = self.share * float(setup.standard_path().force_n.iloc[-1])
        return setup.pressed(paddle, Force(newton, setup.smallest_mm, FORCE_TOLERANCE))


@dataclass(frozen=True)
class ForceNewton:
    """At a force in N."""

    newton: float

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion."""
        return setup.pressed(paddle, Force(self.newton, setup.smallest_mm, FORCE_TOLERANCE))


@dataclass(frozen=True)
class MeanPressure:
    """At a mean pressure, force over area of contact, in kPa for each set of moduli."""

    kpa: Mapping[str, float]

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion; by the secant between two steps of the standard's path, or of a longer one.

        Where the pressure jumps past the one asked for, the breast is that right behind the jump.
        """
        if setup.moduli not in self.kpa:
            known = ", ".join(self.kpa)
            raise MechanicsError(f"no pressure_kpa is stated for {setup.moduli!r} moduli, only for: {known}")
        goal = self.kpa[setup.moduli]
        low, high = self._bracket(setup, paddle, goal)
        while True:
            share = np.clip((goal - low[1]) / (high[1] - low[1]), 0.1, 0.9)
            found = setup.pressed(paddle, Thickness(low[0] + share * (high[0] - low[0])))
            last = found.path.iloc[-1]
            here = (float(last.readout_mm), float(last.mean_pressure_kpa))
            if abs(here[1] / goal - 1) <= PRESSURE_TOLERANCE:
                return found
            low, high = (here, high) if here[1] < goal else (low, here)
            if low[0] - high[0] < JUMP_MM:
                return found if here == high else setup.pressed(paddle, Thickness(high[0]))

    def _bracket(self, setup: PressSetup, paddle: Paddle, goal: float) -> tuple[Step, Step]:
        """The last two steps between which the mean pressure rises above the goal."""
        path = setup.standard_path()
        if path.mean_pressure_kpa.max() < goal:
            path = setup.pressed(paddle, Thickness(setup.smallest_mm)).path
        p = path.mean_pressure_kpa.to_numpy()
        rises = np.flatnonzero((p[:-1] < goal) & (p[1:] >= goal))
        if len(rises) == 0:
            raise MechanicsError(
                f"the mean pressure is {p.max():.3g} kPa at most, down to {path.readout_mm.iloc[-1]:g} mm, "
                f"and never {goal:g} kPa: ask for less, or allow a smaller thickness"
            )
        before, after = (
            (float(row.readout_mm), float(row.mean_pressure_kpa))
            for row in path.iloc[[rises[-1], rises[-1] + 1]].itertuples()
        )
        return before, after


UNTIL: Mapping[str, Callable[[Any], StoppingCriterion]] = {
    "thickness_share": ThicknessShare,
    "force_share": ForceShare,
    "force_n": ForceNewton,
    "pressure_kpa": MeanPressure,
}


@dataclass(frozen=True)
class Strategy:
    """A paddle, and when it stops."""

    paddle: Paddle
    until: StoppingCriterion

    @classmethod
    def of(cls, values: Mapping[str, Mapping[str, Any]]) -> "Strategy":
        """Of the nested plain values {'paddle': {name: {...}}, 'until': {name: value}}; no paddle is rigid.

        Raises ConfigurationError for an unknown name, MechanicsError for a paddle that cannot be.
        """
        ((until, when),) = values["until"].items()
        if until not in UNTIL:
            raise ConfigurationError(f"no end {until!r} of a compression; choose one of: {', '.join(UNTIL)}")
        paddle: Paddle = Rigid()
        for name, parameters in values.get("paddle", {}).items():
            if name not in PADDLES:
                raise ConfigurationError(f"no paddle {name!r}; choose one of: {', '.join(PADDLES)}")
            paddle = PADDLES[name](**parameters)
        return cls(paddle, UNTIL[until](when))

    def press(self, setup: PressSetup) -> Compression:
        """The breast where the paddle stops. Raises MechanicsError, or EquilibriumError, where it cannot."""
        return self.until.press(setup, self.paddle)
