"""Test problems of the hard cases: a body, what it is made of, what holds it, what acts on it and presses it.

The chest wall is the plane z = 0; plates lie across y, their chest edge faces the chest wall.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.settings import (
    Count,
    Limits,
    NotNegative,
    OneOf,
    Positive,
    Settings,
    Triple,
    Unchecked,
)
from mammosim.core.tissues import Tissue, tissues_by_label
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.compression import compress
from mammosim.mechanics.effects import (
    Effect,
    EllipticCylinder,
    RoundedBox,
    Sliding,
    Weight,
    chest_wall_contact,
)
from mammosim.mechanics.equilibrium import Equilibrium, equilibrium, held_nodes
from mammosim.mechanics.equilibrium import Settings as SolverSettings
from mammosim.mechanics.paddles import Flexible, Friction, Plates, Rigid, Tilting
from mammosim.mechanics.stage import Control, Force, Thickness
from mammosim.study.hard_cases.bodies import Ball, Brick, Length

_BROAD_MM, _EDGE_MM = 300.0, 10.0  # half sizes of the block whose upper face is a plane wall, its edge radius
# The first axis of plates points outward along z, the last, from support to paddle, along y.
_PLATE_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T
_HALF_DEPTH_MM, _HALF_HEIGHT_MM = 60.0, 15.0
_RIGID = Rigid()

Wall = RoundedBox | EllipticCylinder
Held = tuple[np.ndarray | None, np.ndarray | None]


@dataclass(frozen=True)
class TestProblem:
    """mesh: the reference; gravity (3,), a unit vector, or None; skin: as a membrane.

    wall: of contact with the skin, penalty contact [kPa/mm], or of sliding, (eps, kappa) [kPa/mm].
    held (n_node, 3) bool; start (n_node, 3) mm, where the held nodes stay; load_steps to begin with.
    plates, if there are any, between which it comes under its weight, as control says.
    """

    mesh: TetMesh
    tissues: Mapping[Label, Tissue]
    gravity: np.ndarray | None
    held: np.ndarray | None
    start: np.ndarray | None = None
    skin: Skin | None = None
    wall: Wall | None = None
    contact: float | None = None
    sliding: tuple[float, float] | None = None
    load_steps: int = 1
    plates: Plates | None = None
    control: Control | None = None

    def effects(self) -> tuple[Effect, ...]:
        """Everything elastic, and the walls."""
        effects = list(body_effects(self.mesh, self.tissues, skin=self.skin))
        if self.wall is not None and self.contact is not None:
            effects.append(chest_wall_contact(self.mesh, self.wall, boundary="skin", penalty=self.contact))
        if self.wall is not None and self.sliding is not None:
            eps, kappa = self.sliding
            effects.append(Sliding.of(self.mesh, self.wall, normal_stiffness=eps, tangential_stiffness=kappa))
        return tuple(effects)

    def equilibrium(self, *, start: np.ndarray | None = None) -> Equilibrium:
        """The equilibrium of the problem, from `start` or its own.

        Raises MechanicsError for an ill-posed problem, EquilibriumError when no verified one was reached.
        """
        weight = () if self.gravity is None else (Weight.of(self.mesh, self.tissues, self.gravity),)
        if self.plates is not None and self.control is not None:
            effects = (*self.effects(), *weight)
            pressed = compress(self.mesh, effects, plates=self.plates, control=self.control, held=self.held)
            return pressed.equilibrium
        return equilibrium(
            self.mesh,
            self.effects(),
            loads=weight,
            start=self.start if start is None else start,
            held=self.held,
            settings=SolverSettings(load_steps=self.load_steps),
        )


@dataclass(frozen=True)
class TissueValues(Settings):
    """As configured: values that cannot be are for the mechanics to reject."""

    youngs_modulus_kpa: Unchecked
    poisson_ratio: Unchecked
    density_g_cm3: Unchecked


@dataclass(frozen=True)
class SkinValues(Settings):
    """As configured, a membrane; as TissueValues."""

    youngs_modulus_kpa: Unchecked
    poisson_ratio: Unchecked
    thickness_mm: Unchecked


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
class PressValues(Settings):
    """Plates that begin at z = chest_edge_mm, and to what they press: one of thickness_mm and force_n."""

    edge_radius_mm: Length
    chest_edge_mm: Annotated[float, Limits(at_least=-50, at_most=1000)]
    thickness_mm: Length | None = None
    force_n: Annotated[float, Limits(above=0, at_most=1000)] | None = None
    half_width_mm: Length = 80.0
    friction: Annotated[float, Limits(at_least=0, at_most=2)] | None = None
    paddle: Annotated[
        Rigid | Tilting | Flexible, OneOf({"rigid": Rigid, "tilting": Tilting, "flexible": Flexible})
    ] = _RIGID

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.thickness_mm is None) == (self.force_n is None):
            raise ConfigurationError("plates press to one of thickness_mm and force_n; give exactly one")

    def plates(self) -> Plates:
        centre = np.array([0.0, 0.0, self.chest_edge_mm + _HALF_DEPTH_MM])
        half = np.array([_HALF_DEPTH_MM, self.half_width_mm, _HALF_HEIGHT_MM])
        friction = None if self.friction is None else Friction(self.friction)
        return Plates(centre, _PLATE_AXES, half, self.edge_radius_mm, self.paddle, friction)

    def control(self) -> Control:
        return Force(self.force_n) if self.force_n is not None else Thickness(self.thickness_mm or 0.0)


@dataclass(frozen=True)
class ProblemSettings(Settings):
    """A test problem as `config/hard_cases.yaml` has it; held: a name of HELD; stretch: of plane_strain."""

    body: Annotated[Ball | Brick, OneOf({"ball": Ball, "brick": Brick}, key="shape")]
    tissues: Mapping[Literal["adipose", "skin"], TissueValues]
    gravity: Triple | None = None
    held: Literal["posterior", "rollers", "plane_strain", "symmetry"] = "posterior"
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
            tissues_by_label({name: vars(values) for name, values in self.tissues.items()}),
            None if self.gravity is None else np.array(self.gravity),
            held,
            start,
            skin=None if self.skin is None else Skin(**vars(self.skin)),
            wall=None if self.wall is None else self.wall.wall(),
            contact=self.contact_kpa_mm,
            sliding=self.sliding_kpa_mm,
            load_steps=self.load_steps,
            plates=None if self.press is None else self.press.plates(),
            control=None if self.press is None else self.press.control(),
        )

    def refined(self, edge_mm: float) -> "ProblemSettings":
        """The same with other elements. Raises ConfigurationError for a brick, which has no edge_mm."""
        if not isinstance(self.body, Ball):
            raise ConfigurationError("a brick has no edge_mm to refine; use another reference")
        return replace(self, body=replace(self.body, edge_mm=edge_mm))


def _posterior(mesh: TetMesh, stretch: float) -> Held:
    return (held_nodes(mesh) if "posterior" in mesh.boundaries else None), None


def _at(mesh: TetMesh, axis: int, place: float) -> np.ndarray:
    return np.isclose(mesh.points[:, axis], place)


def _rollers(mesh: TetMesh, stretch: float) -> Held:
    """No lateral displacement anywhere; the face z = 0 is held."""
    held = np.ones(mesh.points.shape, dtype=bool)
    held[:, 2] = _at(mesh, 2, 0.0)
    return held, None


def _plane_strain(mesh: TetMesh, stretch: float) -> Held:
    """Stretched along x, nothing moves along y, the face z = 0 stays in its plane."""
    ends = _at(mesh, 0, 0.0) | _at(mesh, 0, mesh.points[:, 0].max())
    held = np.stack([ends, np.ones(len(ends), dtype=bool), _at(mesh, 2, 0.0)], axis=1)
    return held, mesh.points * [stretch, 1.0, 1.0]


def _symmetry(mesh: TetMesh, stretch: float) -> Held:
    """The face y = 0 stays in its plane; nothing else is held."""
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[:, 1] = _at(mesh, 1, 0.0)
    return held, None


HELD: Mapping[str, Callable[[TetMesh, float], Held]] = {
    "posterior": _posterior,
    "rollers": _rollers,
    "plane_strain": _plane_strain,
    "symmetry": _symmetry,
}
