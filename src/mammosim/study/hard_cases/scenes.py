"""Scenes of the hard cases: a body, what it is made of, what holds it and what acts on it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue, tissues_by_label
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.effects import (
    Effect,
    EllipticCylinder,
    RoundedBox,
    Sliding,
    Weight,
    chest_wall_contact,
)
from mammosim.mechanics.equilibrium import Equilibrium, Settings, equilibrium, held_nodes
from mammosim.study.hard_cases.bodies import body
from mammosim.study.hard_cases.presses import Pressing

_BROAD_MM, _EDGE_MM = 300.0, 10.0  # half sizes of the block whose upper face is a plane wall, its edge radius

Wall = RoundedBox | EllipticCylinder


@dataclass(frozen=True)
class Scene:
    """mesh: the reference; gravity (3,), a unit vector, or None; skin: as a membrane.

    wall: of contact with the skin, penalty contact [kPa/mm], or of sliding, (eps, kappa) [kPa/mm].
    held (n_node, 3) bool; start (n_node, 3) mm, where the held nodes stay; load_steps to begin with.
    press: the plates, if there are any, between which it comes under its weight.
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
    press: Pressing | None = None

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
        """The equilibrium of the scene, from `start` or its own.

        Raises MechanicsError for an ill-posed scene, EquilibriumError when no verified one was reached.
        """
        weight = () if self.gravity is None else (Weight.of(self.mesh, self.tissues, self.gravity),)
        if self.press is not None:
            return self.press.equilibrium(self.mesh, (*self.effects(), *weight), self.held)
        return equilibrium(
            self.mesh,
            self.effects(),
            loads=weight,
            start=self.start if start is None else start,
            held=self.held,
            settings=Settings(load_steps=self.load_steps),
        )


def scene(values: Mapping[str, Any]) -> Scene:
    """The scene of nested plain values, as `config/hard_cases.yaml` describes it.

    Raises MammosimError for a body or tissue that cannot be.
    """
    mesh = body(**values["body"])
    held, start = HELD[values.get("held", "posterior")](mesh, values.get("stretch", 1.0))
    gravity = values.get("gravity")
    wall = values.get("wall")
    return Scene(
        mesh,
        tissues_by_label(values["tissues"]),
        None if gravity is None else np.array(gravity, dtype=float),
        held,
        start,
        skin=Skin(**values["skin"]) if "skin" in values else None,
        wall=WALLS[wall["shape"]](**{k: v for k, v in wall.items() if k != "shape"}) if wall else None,
        contact=values.get("contact_kpa_mm"),
        sliding=tuple(values["sliding_kpa_mm"]) if "sliding_kpa_mm" in values else None,
        load_steps=values.get("load_steps", 1),
        press=Pressing.of(**values["press"]) if "press" in values else None,
    )


def _plane() -> RoundedBox:
    """The chest wall z = 0: the upper face of a broad block."""
    centre, half = np.array([0.0, 0.0, -_BROAD_MM]), np.full(3, _BROAD_MM)
    return RoundedBox(centre, np.eye(3), half, _EDGE_MM)


def _cylinder(*, semi_axes_mm: list[float], centre_mm: list[float]) -> EllipticCylinder:
    """A chest wall whose axis is y, semi-axes along x and z."""
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return EllipticCylinder(np.array(centre_mm), np.array(semi_axes_mm), axes)


WALLS: Mapping[str, Callable[..., Wall]] = {"plane": _plane, "cylinder": _cylinder}

Held = tuple[np.ndarray | None, np.ndarray | None]


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
