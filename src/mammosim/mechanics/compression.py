"""Compression of a body between two rigid plates that approach each other."""

import logging
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.units import MN_PER_N
from mammosim.mechanics.analysis import system_of
from mammosim.mechanics.effects import (
    ContactState,
    Effect,
    MixedNeoHookean,
    NeoHookean,
    RigidPlate,
    RoundedBox,
)
from mammosim.mechanics.equilibrium import Equilibrium, Settings, held_nodes, solve
from mammosim.mechanics.newton import NewtonSettings, System
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.reference import face_quadrature
from mammosim.mechanics.soundness import require_well_posed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Plates:
    """Two equal plates, paddle and support, that face each other symmetrically about a centre.

    centre (3,) mm; axes (3, 3): orthonormal columns, the last one points from the support to the paddle;
    half_sizes (3,) mm of each plate along them; edge_radius_mm of all its edges.
    """

    centre: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray
    edge_radius_mm: float

    @classmethod
    def covering(
        cls,
        points: np.ndarray,
        *,
        direction: np.ndarray,
        outward: np.ndarray,
        margin_mm: float = 20.0,
        plate_thickness_mm: float = 20.0,
        edge_radius_mm: float = 8.0,
    ) -> "Plates":
        """Plates across `direction` (3,) that cover points (n, 3) and a margin around, but none behind them.

        outward (3,): from the chest wall to the nipple; behind the points, the plates end where the points
        do.
        """
        a = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
        b = np.asarray(outward, dtype=float) - np.dot(outward, a) * a
        b /= np.linalg.norm(b)
        axes = np.column_stack([b, np.cross(a, b), a])
        low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
        low = low - np.array([0.0, margin_mm, 0.0])
        high = high + np.array([margin_mm, margin_mm, 0.0])
        half = (high - low) / 2
        half[2] = plate_thickness_mm / 2
        return cls(axes @ (low + high) / 2, axes, half, edge_radius_mm)

    def at(self, thickness_mm: float) -> tuple[RoundedBox, RoundedBox]:
        """Paddle and support with this distance between their faces."""
        reach = (thickness_mm / 2 + self.half_sizes[2]) * self.axes[:, 2]
        paddle, support = (
            RoundedBox(self.centre + side * reach, self.axes, self.half_sizes, self.edge_radius_mm)
            for side in (1, -1)
        )
        return paddle, support

    def first_contact(self, points: np.ndarray) -> float:
        """The largest distance between the faces at which a plate touches points (n, 3), mm."""
        y = (points - self.centre) @ self.axes
        under = np.all(np.abs(y[:, :2]) <= self.half_sizes[:2], axis=1)
        if not under.any():
            raise MechanicsError("no skin node lies between the plates; move their centre, or enlarge them")
        return 2 * float(np.abs(y[under, 2]).max())


@dataclass(frozen=True)
class PressSettings:
    """steps: the number of equal steps to begin with; penetration_mm: the largest that is accepted.

    penalty_kpa_per_mm: of the contact to begin with; None takes 30 times the bulk's median shear modulus.
    solver: by default without trusted steps, since contact opens and closes (decisions/mechanics_newton.md).
    """

    steps: int = 8
    smallest_step_mm: float = 0.05
    penetration_mm: float = 0.2
    penalty_kpa_per_mm: float | None = None
    solver: Settings = field(default_factory=lambda: Settings(newton=NewtonSettings(trusted=0)))


@dataclass(frozen=True)
class Compression:
    """points (n_node, 3) mm; plates: paddle and support at the end, contacts: their state.

    path: one row per step: thickness_mm, force_n (paddle), support_force_n, contact_area_mm2 (paddle),
    mean_pressure_kpa, peak_pressure_kpa (largest mean pressure of a face), penetration_mm, energy_uj,
    smallest_J, iterations.
    """

    points: np.ndarray
    path: pd.DataFrame
    equilibrium: Equilibrium
    plates: tuple[RigidPlate, RigidPlate]
    contacts: tuple[ContactState, ContactState]


@dataclass(frozen=True)
class _Stage:
    """A body pressed to a thickness."""

    thickness: float
    plates: tuple[RigidPlate, RigidPlate]
    state: Equilibrium

    @property
    def x(self) -> np.ndarray:
        """The pressed shape (n_node, 3), mm."""
        return self.state.points

    def contacts(self) -> tuple[ContactState, ContactState]:
        """What paddle and support do to the skin."""
        paddle, support = self.plates
        return paddle.state(self.x), support.state(self.x)

    @property
    def penetration(self) -> float:
        """How deep the skin is in a plate at most, mm."""
        return max(contact.penetration for contact in self.contacts())


def compress(
    mesh: TetMesh,
    effects: tuple[Effect, ...],
    *,
    plates: Plates,
    thickness_mm: float,
    held: np.ndarray | None = None,
    settings: PressSettings | None = None,
) -> Compression:
    """Press a body, whose mesh.points are stress-free, without friction to thickness_mm between the plates.

    The plates start at first contact and approach symmetrically; a step that fails is halved. effects may
    hold more than tissue and skin, such as weight. held (n_node, 3) bool, default all components of the nodes
    of `posterior`. Raises MechanicsError when the asked thickness is not below that of first contact,
    EquilibriumError when no verified equilibrium was reached; its message names the thickness that was.
    """
    settings = settings or PressSettings()
    held = held_nodes(mesh) if held is None and "posterior" in mesh.boundaries else held
    held = require_well_posed(mesh, held)
    faces = mesh.boundaries["skin"]
    contact = plates.first_contact(mesh.points[np.unique(faces)])
    if not 0 < thickness_mm < contact:
        raise MechanicsError(
            f"thickness_mm = {thickness_mm:g} is outside (0, {contact:.1f}), where the plates touch first"
        )
    areas = face_quadrature(mesh.points, faces).areas
    penalty = settings.penalty_kpa_per_mm or _penalty(effects)
    paddle, support = (RigidPlate(faces, areas, box, penalty) for box in plates.at(contact))
    with system_of(Potential((*effects, paddle, support)), held) as system:
        press = _Press(system, mesh.points, effects, plates, settings)
        stages = press.path(press.pressed(mesh.points, (paddle, support), contact), thickness_mm)
    last = stages[-1]
    path = pd.DataFrame([_row(stage, plates.axes[:, 2]) for stage in stages])
    return Compression(last.x, path, last.state, last.plates, last.contacts())


def _penalty(effects: tuple[Effect, ...]) -> float:
    """30 times the median shear modulus of the cells, per mm."""
    mu = np.concatenate(
        [effect.mu for effect in effects if isinstance(effect, (NeoHookean, MixedNeoHookean))]
    )
    return 30.0 * float(np.median(mu))


@dataclass(frozen=True)
class _Press:
    """What stays the same while a body is pressed."""

    system: System
    reference: np.ndarray
    effects: tuple[Effect, ...]
    plates: Plates
    settings: PressSettings

    def path(self, first: _Stage, thickness: float) -> list[_Stage]:
        """The stages from first contact to a thickness; a step that fails is halved."""
        stages = [first]
        step = (first.thickness - thickness) / self.settings.steps
        while stages[-1].thickness > thickness:
            target = max(thickness, stages[-1].thickness - step)
            try:
                stages.append(self.pressed(stages[-1].x, stages[-1].plates, target))
            except EquilibriumError as error:
                step /= 2
                log.info("compression to %.2f mm failed, halving the step: %s", target, error)
                if step < self.settings.smallest_step_mm:
                    raise EquilibriumError(
                        f"compression to {thickness:g} mm stopped at {stages[-1].thickness:.2f} mm: {error}",
                        history=error.history,
                    ) from error
        return stages

    def pressed(self, x: np.ndarray, plates: tuple[RigidPlate, RigidPlate], thickness: float) -> _Stage:
        """The stage at a thickness, from the shape x, with a penalty that keeps the penetration small."""
        penalty = plates[0].penalty
        boxes = self.plates.at(thickness)
        while True:
            paddle, support = (
                replace(plate, obstacle=box, penalty=penalty) for plate, box in zip(plates, boxes)
            )
            system = replace(self.system, potential=Potential((*self.effects, paddle, support)))
            state = solve(system, self.reference, start=x, settings=self.settings.solver)
            stage = _Stage(thickness, (paddle, support), state)
            if stage.penetration <= self.settings.penetration_mm:
                return stage
            x, penalty = state.points, 4 * penalty


def _row(stage: _Stage, axis: np.ndarray) -> dict[str, float]:
    """A row of Compression.path; axis (3,) points from the support to the paddle."""
    paddle, support = stage.contacts()
    force = float(paddle.force @ axis)
    return {
        "thickness_mm": stage.thickness,
        "force_n": force / MN_PER_N,
        "support_force_n": -float(support.force @ axis) / MN_PER_N,
        "contact_area_mm2": paddle.area,
        "mean_pressure_kpa": force / paddle.area if paddle.area > 0 else 0.0,
        "peak_pressure_kpa": float(paddle.pressure.mean(axis=1).max()),
        "penetration_mm": stage.penetration,
        "energy_uj": stage.state.energy,
        "smallest_J": stage.state.smallest_J,
        "iterations": len(stage.state.history) - 1,
    }
