"""Strategies of compression: which paddle presses, and where it stops."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, get_type_hints

import numpy as np
import pandas as pd

from mammosim.chain.discomfort import path_of
from mammosim.chain.paddles import Plate
from mammosim.chain.plates import PlateSize
from mammosim.chain.thickness import GIVEN
from mammosim.core.errors import ConfigurationError, MammosimError, MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.settings import annotations, read, require_positive
from mammosim.mechanics.compression import Compression, PressSettings, compress, continued
from mammosim.mechanics.effects import Cushion, Effect, RigidPlate, six_points_in_each
from mammosim.mechanics.paddles import Paddle, Plates, Rigid
from mammosim.mechanics.press_path import WarmStart
from mammosim.mechanics.reference import faces_of
from mammosim.mechanics.stage import Control, Force, Thickness

STANDARD = "standard"
# A force, and a mean pressure, are met within these parts of them.
FORCE_TOLERANCE, PRESSURE_TOLERANCE = 1e-3, 0.02
# A paddle that yields leaves the load path of the rigid one at this part of the force that it is to reach; in
# longer steps the tissue may slip out toward the chest, to a state that never reaches it.
YIELDS_FROM, YIELDING_STEPS = 0.5, 16
# On a mesh the area of contact grows in jumps: where one passes the pressure, the plates stop this near it.
JUMP_MM = 0.5
_RIGID = Rigid()
Step = tuple[float, float]  # distance of the plates in mm, and mean pressure there in kPa


class NoStandard(MechanicsError):
    """The goal of a strategy depends on the standard one, which found no equilibrium."""


class PressedState(Protocol):
    """A breast where a paddle stopped: what is measured of it. Compression of mechanics is one.

    points (n_node, 3) mm; path: one row per step; plates: paddle and support.
    """

    @property
    def points(self) -> np.ndarray: ...
    @property
    def path(self) -> pd.DataFrame: ...
    @property
    def plates(self) -> tuple[RigidPlate, RigidPlate]: ...

    def gap(self, points: np.ndarray) -> np.ndarray:
        """Distance between the faces of the plates at points (n, 3), (n,) mm; NaN beside the plates."""
        ...

    def room(self, points: np.ndarray) -> tuple[float, float]:
        """How far paddle and support are beyond flat ones over points (n, 3), mm; see Plates.room."""
        ...


@dataclass(frozen=True)
class PressSetup:
    """One breast to press.

    mesh: stress-free; plates: where a rigid paddle would stand; moduli: the name of the set in the effects;
    thickness_mm: of the standard strategy; smallest_mm: no paddle goes further; standard: the load path of
    the standard strategy of the same breast and moduli, None where it is not known; solved: how a rigid
    paddle's path is; thickness_from: chain.thickness.StandardThickness.origin; moduli_factor: by what all
    moduli of the effects were multiplied; chest_gap_mm, chest_gap_from: chain.plates.PlacedPlates; held
    (n_node, 3) bool: None for the nodes of `posterior`.
    """

    mesh: TetMesh
    effects: tuple[Effect, ...]
    plates: Plates
    moduli: str
    thickness_mm: float
    smallest_mm: float
    standard: "LoadPath | None" = None
    solved: PressSettings = field(default_factory=PressSettings)
    thickness_from: str = GIVEN
    moduli_factor: float = 1.0
    chest_gap_mm: float = float("nan")
    chest_gap_from: str = GIVEN
    held: np.ndarray | None = None

    def pressed(self, paddle: Paddle, control: Control) -> Compression:
        """The breast between support and paddle; raises as mechanics.compression.compress.

        Every flat paddle continues the load path of the standard strategy where that is known and can be
        used: the path of one that yields begins where it leaves it, and has no work. Area and pressures:
        chain.discomfort.
        """
        body, plates = (self.mesh, self.effects), replace(self.plates, paddle=paddle)
        settings = replace(self.solved, steps=YIELDING_STEPS) if paddle.unknowns else self.solved
        # Friction depends on the whole load path, and the stages that are kept do not have its state.
        known = self.standard if plates.friction is None and plates.flat else None
        warm_starts = known.warm_starts(paddle, control) if known else ()
        if not warm_starts:
            found = compress(*body, plates=plates, control=control, held=self.held, settings=settings)
            return replace(found, path=path_of(found))
        found = continued(
            *body, plates=plates, control=control, warm_starts=warm_starts, held=self.held, settings=settings
        )
        path = path_of(found)
        if paddle != Rigid():
            path = path.iloc[len(warm_starts) :].assign(work_uj=np.nan)
        return replace(found, path=path)

    def standard_path(self) -> pd.DataFrame:
        """Of the standard strategy. Raises NoStandard where that is not known."""
        if not self.standard:
            raise NoStandard("the standard strategy, which this one is measured by, found no equilibrium")
        return self.standard.path


@dataclass(frozen=True)
class LoadPath:
    """The steps of a compression: path of mechanics.compression.Compression; shapes (n_step, n_node, 3) mm.

    multipliers (n_step, 2, n_face, 6) kPa, of paddle and support on the faces of the skin, see RigidPlate;
    mesh: in the last step.
    """

    path: pd.DataFrame
    shapes: np.ndarray
    multipliers: np.ndarray
    mesh: TetMesh

    @classmethod
    def of(cls, mesh: TetMesh, found: Compression) -> "LoadPath":
        """Of a compression of a mesh."""
        empty = np.zeros((len(faces_of(mesh, "skin")), 6))
        multipliers = [[empty + contact.multiplier for contact in stage.contacts] for stage in found.stages]
        shapes = np.array([stage.x for stage in found.stages])
        return cls(found.path, shapes, np.array(multipliers), mesh.moved_to(found.points))

    @staticmethod
    def names(count: int) -> list[str]:
        """What the shapes of so many steps are called in a file."""
        return [f"step_{number:02d}" for number in range(count)]

    def point_data(self) -> dict[str, np.ndarray]:
        """The shapes by their names."""
        return dict(zip(self.names(len(self.shapes)), self.shapes, strict=True))

    def skin_data(self) -> dict[str, np.ndarray]:
        """The multipliers of each face by the names of the steps (n_face, 2, 6)."""
        on_faces = np.moveaxis(self.multipliers, 2, 1)
        return dict(zip(self.names(len(on_faces)), on_faces, strict=True))

    def end(self, setup: PressSetup) -> "PathEnd":
        """The breast of a setup at the end of its load path, which is that of a rigid paddle."""
        last = self.path.iloc[-1]
        faces, rule = faces_of(setup.mesh, "skin"), six_points_in_each(setup.solved.parts)
        areas = rule.areas(setup.mesh.points, faces)
        paddle, support = (
            RigidPlate(faces, areas, box, float(last.penalty_kpa_per_mm), rule, cushion, multiplier)
            for box, cushion, multiplier in zip(
                setup.plates.at(float(last.readout_mm)), setup.plates.cushions, self.multipliers[-1]
            )
        )
        return PathEnd(self.shapes[-1], self.path, (paddle, support), setup.plates)

    def warm_starts(self, paddle: Paddle, control: Control) -> tuple[WarmStart, ...]:
        """The stages that a paddle can begin with: one that yields, of less than half the force."""
        path = self.path
        if paddle != Rigid():
            below = (
                path.force_n < YIELDS_FROM * control.newton if isinstance(control, Force) else path.index < 0
            )
            path = path[below]
        steps = zip(path.readout_mm, path.penalty_kpa_per_mm, self.shapes, self.multipliers)
        return tuple(
            WarmStart(float(thickness), float(penalty), x, multipliers)
            for thickness, penalty, x, multipliers in steps
        )


@dataclass(frozen=True)
class PathEnd:
    """The last step of a load path, without what its solver knew: a PressedState.

    between: the plates, whose distance is that of the path's last row.
    """

    points: np.ndarray
    path: pd.DataFrame
    plates: tuple[RigidPlate, RigidPlate]
    between: Plates

    def gap(self, points: np.ndarray) -> np.ndarray:
        """See PressedState."""
        return self.between.gap(points, float(self.path.readout_mm.iloc[-1]), self.between.at_rest)

    def room(self, points: np.ndarray) -> tuple[float, float]:
        """See PressedState."""
        return self.between.room(points, float(self.path.readout_mm.iloc[-1]), self.between.at_rest)


class StoppingCriterion(Protocol):
    """When a paddle stops."""

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """The breast where it stops. Raises MechanicsError (or EquilibriumError) where it cannot."""
        ...


@dataclass(frozen=True)
class ThicknessShare:
    """At a share of the standard strategy's thickness."""

    share: float

    def __post_init__(self) -> None:
        require_positive(self, "share")

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

    def __post_init__(self) -> None:
        require_positive(self, "share")

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion."""
        newton = self.share * float(setup.standard_path().force_n.iloc[-1])
        return setup.pressed(paddle, Force(newton, setup.smallest_mm, FORCE_TOLERANCE))


@dataclass(frozen=True)
class ForceNewton:
    """At a force in N."""

    newton: float

    def __post_init__(self) -> None:
        require_positive(self, "newton")

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion."""
        return setup.pressed(paddle, Force(self.newton, setup.smallest_mm, FORCE_TOLERANCE))


@dataclass(frozen=True)
class MeanPressure:
    """At a mean pressure, force over area of contact, in kPa for each set of moduli."""

    kpa: Mapping[str, float]

    def __post_init__(self) -> None:
        if not self.kpa or not all(0 < p < np.inf for p in self.kpa.values()):
            raise ConfigurationError(
                f"pressures {dict(self.kpa)} kPa: give one above 0 for each set of moduli"
            )

    def press(self, setup: PressSetup, paddle: Paddle) -> Compression:
        """See StoppingCriterion; by the secant between two steps of the standard's path, or of a longer one.

        Where the pressure jumps past the goal, the breast is that right behind the jump.
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
        """The last two steps between which the mean pressure rises above the goal.

        Plates that are not flat have a path of their own.
        """
        path = setup.standard_path()
        flat = replace(setup.plates, paddle=paddle).flat
        if not flat or path.mean_pressure_kpa.max() < goal:
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


CRITERIA: Mapping[str, type[StoppingCriterion]] = {
    "thickness_share": ThicknessShare,
    "force_share": ForceShare,
    "force_n": ForceNewton,
    "pressure_kpa": MeanPressure,
}


@dataclass(frozen=True)
class Strategy:
    """A paddle, when it stops, the support, and the cushions on both."""

    paddle: Paddle
    until: StoppingCriterion
    support: Paddle = _RIGID
    cushions: tuple[Cushion | None, Cushion | None] = (None, None)

    @classmethod
    def read(cls, values: Any, *, at: str = "strategy") -> "Strategy":
        """Of the nested plain values {'paddle': {name: {...}}, 'support': {...}, 'until': {name: value}}.

        paddle, support: chain.paddles.Plate; rigid and flat where they are not there. at: what an error calls
        them. Raises ConfigurationError for an unknown name, and for a value that no plate and no criterion
        takes.
        """
        given = read(_Given, values, at)
        until, goal = _only(given.until, CRITERIA, at=f"{at}.until")
        criterion = CRITERIA[until]
        (name,) = annotations(criterion)
        goal = read(get_type_hints(criterion)[name], goal, f"{at}.until.{until}")
        paddle, support = (
            Plate.read(getattr(given, plate), at=f"{at}.{plate}") for plate in ("paddle", "support")
        )
        if support.paddle.unknowns:
            raise ConfigurationError(
                f"{at}.support = {dict(given.support)!r}: a support does not yield, only a paddle"
            )
        return cls(
            paddle.paddle,
            read(criterion, {name: goal}, f"{at}.until.{until}"),
            support.paddle,
            (paddle.cushion, support.cushion),
        )

    def require_possible(self, plate_mm: PlateSize, *, at: str = "strategy") -> None:
        """Raise ConfigurationError, which names `at`, where plates of that size cannot be as described."""
        half = np.array([plate_mm.depth, plate_mm.width, plate_mm.height]) / 2
        try:
            self.plates(Plates(np.zeros(3), np.eye(3), half, plate_mm.edge_radius)).require_possible()
        except MammosimError as error:
            raise ConfigurationError(f"{at}: {error}") from None

    def plates(self, flat: Plates) -> Plates:
        """Support, paddle and cushions in the place of flat ones."""
        return replace(flat, paddle=self.paddle, support=self.support, cushions=self.cushions)

    def press(self, setup: PressSetup) -> Compression:
        """The breast where the paddle stops. Raises MechanicsError, or EquilibriumError, where it cannot."""
        return self.until.press(replace(setup, plates=self.plates(setup.plates)), self.paddle)


@dataclass(frozen=True)
class _Given:
    until: Mapping[str, Any]
    paddle: Mapping[str, Any] = field(default_factory=dict)
    support: Mapping[str, Any] = field(default_factory=dict)


def _only(values: Mapping[str, Any], known: Mapping[str, Any], *, at: str) -> tuple[str, Any]:
    """The one name and value that is there. Raises ConfigurationError unless there is one that is known."""
    if len(values) != 1 or not set(values) <= set(known):
        raise ConfigurationError(f"{at} = {dict(values)!r}; give exactly one of: {', '.join(known)}")
    return next(iter(values.items()))
