"""Test problems of the hard cases: a body, what it is made of, what holds it, what acts on it and presses it.

The chest wall is the plane z = 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.settings import (
    Count,
    Limits,
    NotNegative,
    OneOf,
    Positive,
    Settings,
    Triple,
)
from mammosim.core.tissues import Tissues
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.compression import Compression, compress
from mammosim.mechanics.effects import (
    Effect,
    EllipticCylinder,
    RoundedBox,
    Sliding,
    Weight,
    chest_wall_contact,
)
from mammosim.mechanics.equilibrium import Equilibrium, equilibrium
from mammosim.mechanics.equilibrium import Settings as SolverSettings
from mammosim.study.hard_cases.bodies import Ball, Brick, Length
from mammosim.study.hard_cases.holds import HELD, HeldNames
from mammosim.study.hard_cases.materials import Scatter, SkinValues, TissueNames, TissueValues, tissues_of
from mammosim.study.hard_cases.presses import PressSetup, PressValues

_BROAD_MM, _EDGE_MM = 300.0, 10.0  # half sizes of the block whose upper face is a plane wall, its edge radius

Wall = RoundedBox | EllipticCylinder


@dataclass(frozen=True)
class TestProblem:
    """mesh: the reference; gravity (3,), a unit vector, or None; skin: as a membrane.

    wall: of contact with the skin, penalty contact [kPa/mm], or of sliding, (eps, kappa) [kPa/mm].
    held (n_node, 3) bool; start (n_node, 3) mm, where the held nodes stay; load_steps to begin with.
    press: the plates, if there are any, between which it comes under its weight.
    """

    mesh: TetMesh
    tissues: Tissues
    gravity: np.ndarray | None
    held: np.ndarray | None
    start: np.ndarray | None = None
    skin: Skin | None = None
    wall: Wall | None = None
    contact: float | None = None
    sliding: tuple[float, float] | None = None
    load_steps: int = 1
    press: PressSetup | None = None

    def effects(self) -> tuple[Effect, ...]:
        """Everything elastic, and the walls."""
        effects = list(body_effects(self.mesh, self.tissues, skin=self.skin))
        if self.wall is not None and self.contact is not None:
            effects.append(chest_wall_contact(self.mesh, self.wall, boundary="skin", penalty=self.contact))
        if self.wall is not None and self.sliding is not None:
            eps, kappa = self.sliding
            effects.append(Sliding.of(self.mesh, self.wall, normal_stiffness=eps, tangential_stiffness=kappa))
        return tuple(effects)

    def solution(self, *, start: np.ndarray | None = None) -> "Solution":
        """The equilibrium of the problem, from `start` or its own.

        Raises MechanicsError for an ill-posed problem, EquilibriumError when no verified one was reached.
        """
        weight = () if self.gravity is None else (Weight.of(self.mesh, self.tissues, self.gravity),)
        if self.press is not None:
            pressed = compress(
                self.mesh,
                (*self.effects(), *weight),
                plates=self.press.plates,
                control=self.press.control,
                held=self.held,
                settings=self.press.settings,
            )
            return Solution(self, pressed.equilibrium, pressed)
        state = equilibrium(
            self.mesh,
            self.effects(),
            loads=weight,
            start=self.start if start is None else start,
            held=self.held,
            settings=SolverSettings(load_steps=self.load_steps),
        )
        return Solution(self, state)


@dataclass(frozen=True)
class Solution:
    """A test problem with its equilibrium, and how it was pressed where there are plates."""

    problem: TestProblem
    equilibrium: Equilibrium
    pressed: Compression | None = None

    @property
    def x(self) -> np.ndarray:
        """The shape (n_node, 3) mm."""
        return self.equilibrium.points

    @property
    def displacements(self) -> np.ndarray:
        """x - X (n_node, 3) mm."""
        return self.x - self.problem.mesh.points


@dataclass(frozen=True)
class Plane(Settings):
    """The chest wall z = 0: the upper face of a broad block."""

    def wall(self) -> RoundedBox:
        centre, half = np.array([0.0, 0.0, -_BROAD_MM]), np.full(3, _BROAD_MM)
        return RoundedBox(centre, np.eye(3), half, _EDGE_MM)


@dataclass(frozen=True)
class Cylinder(Settings):
    """A chest wall whose axis is y, semi-axes along x and z."""

    semi_axes_mm: tuple[Length, Length]
    centre_mm: Triple

    def wall(self) -> EllipticCylinder:
        axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        return EllipticCylinder(np.array(self.centre_mm), np.array(self.semi_axes_mm), axes)


@dataclass(frozen=True)
class ProblemSettings(Settings):
    """A test problem as `config/hard_cases.yaml` has it; held: a name of HELD; stretch: of plane_strain.

    scatter: of all moduli, at random.
    """

    body: Annotated[Ball | Brick, OneOf({"ball": Ball, "brick": Brick}, key="shape")]
    tissues: Mapping[TissueNames, TissueValues]
    scatter: Scatter | None = None
    gravity: Triple | None = None
    held: HeldNames = "posterior"
    stretch: Annotated[float, Limits(above=0, at_most=3)] = 1.0
    skin: SkinValues | None = None
    wall: Annotated[Plane | Cylinder, OneOf({"plane": Plane, "cylinder": Cylinder}, key="shape")] | None = (
        None
    )
    contact_kpa_mm: Positive | None = None
    sliding_kpa_mm: tuple[NotNegative, NotNegative] | None = None
    load_steps: Count = 1
    press: PressValues | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.wall is None and (self.contact_kpa_mm, self.sliding_kpa_mm) != (None, None):
            raise ConfigurationError("contact_kpa_mm and sliding_kpa_mm are of a wall; add one")

    def problem(self) -> TestProblem:
        """Mesh and all. Raises MammosimError for a body or tissue that cannot be."""
        mesh = self.body.mesh()
        held, start = HELD[self.held](mesh, self.stretch)
        return TestProblem(
            mesh,
            tissues_of(mesh, self.tissues, self.scatter),
            None if self.gravity is None else np.array(self.gravity),
            held,
            start,
            skin=None if self.skin is None else Skin(**vars(self.skin)),
            wall=None if self.wall is None else self.wall.wall(),
            contact=self.contact_kpa_mm,
            sliding=self.sliding_kpa_mm,
            load_steps=self.load_steps,
            press=None if self.press is None else self.press.setup(),
        )

    def refined(self, edge_mm: float) -> "ProblemSettings":
        """The same with other elements. Raises ConfigurationError where that is another body."""
        return replace(self, body=self.body.refined(edge_mm))
