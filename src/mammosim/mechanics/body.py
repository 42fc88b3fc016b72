"""A body under gravity: its tissues, skin, fascia and ligaments as effects, and its equilibrium.

Its left and right halves may have moduli of their own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import CellTissues, Tissue, Tissues
from mammosim.mechanics.effects import (
    Effect,
    Fibres,
    Obstacle,
    SkinMembrane,
    Sliding,
    Weight,
    bulk_tissue,
    chest_wall_contact,
)
from mammosim.mechanics.equilibrium import Equilibrium, Settings, equilibrium, held_nodes
from mammosim.mechanics.ligaments import ligament_directions
from mammosim.mechanics.mixture import cell_tissues
from mammosim.mechanics.reference import face_quadrature, faces_of


@dataclass(frozen=True)
class Skin:
    """Skin as a membrane: E [kPa] and nu [-], of which mu = E / (2 (1 + nu)) enters, and its thickness.

    youngs_modulus_kpa and thickness_mm: a number, or one per face of the boundary (n_face,);
    poisson_ratio: nu; boundary: of the mesh, on which it lies.

    Raises MechanicsError when a parameter is out of range.
    """

    youngs_modulus_kpa: float | np.ndarray
    poisson_ratio: float
    thickness_mm: float | np.ndarray
    boundary: str = "skin"

    def __post_init__(self) -> None:
        for E in np.unique(self.youngs_modulus_kpa):
            Tissue(float(E), self.poisson_ratio, 1.0)
        thickness = np.asarray(self.thickness_mm)
        if not (thickness.min() > 0 and thickness.max() <= 10):
            raise MechanicsError(
                f"thickness_mm from {thickness.min():g} to {thickness.max():g} is outside (0, 10]; "
                "skin has 0.5 to 3 mm, superficial fascia about 0.1 mm"
            )

    def stiffened(self, factor: float) -> "Skin":
        """The same membrane with its modulus times a factor."""
        return replace(self, youngs_modulus_kpa=factor * self.youngs_modulus_kpa)

    def on(self, mesh: TetMesh) -> SkinMembrane:
        """The membrane on the boundary of a mesh whose points are the reference.

        Raises MechanicsError when the mesh has no such boundary.
        """
        faces = faces_of(mesh, self.boundary)
        mu = np.asarray(self.youngs_modulus_kpa) / (2 * (1 + self.poisson_ratio))
        stiffness = np.broadcast_to(mu * np.asarray(self.thickness_mm), (len(faces),)).astype(float)
        return SkinMembrane(faces, face_quadrature(mesh.points, faces), stiffness)


# ASSUME: superficial fascia is a membrane of the same law as skin, on inner faces or right under the skin.
@dataclass(frozen=True)
class Fascia(Skin):
    """Superficial fascia as a membrane, by the law of Skin, on faces inside the body: the boundary `fascia`.

    With boundary="skin" it lies right under the skin.
    """

    boundary: str = "fascia"


# ASSUME: as a part of a body, Cooper's ligaments are fibres of one stiffness wherever there is no muscle.
@dataclass(frozen=True)
class Ligaments:
    """Cooper's ligaments as fibres, see effects.Fibres."""

    stiffness_kpa: float
    exponent: float = 0.0

    def stiffened(self, factor: float) -> "Ligaments":
        """The same fibres with their stiffness times a factor."""
        return replace(self, stiffness_kpa=factor * self.stiffness_kpa)

    def on(self, mesh: TetMesh) -> Fibres:
        """The fibres of a mesh whose points are the reference."""
        directions = ligament_directions(mesh)
        return Fibres.of(mesh, directions, stiffness_kpa=self.stiffness_kpa, exponent=self.exponent)


@dataclass(frozen=True)
class Slides:
    """The back of the body slides on the ribs, see effects.Sliding; what else is held stays so.

    faces (n_face, 6): of the boundary `posterior`, on the ribs; wall: the ribs; stiffness against leaving the
    wall, and of the loose tissue along it, kPa/mm.
    """

    faces: np.ndarray
    wall: Obstacle
    normal_kpa_per_mm: float
    tangential_kpa_per_mm: float

    def stiffened(self, factor: float) -> "Slides":
        """The same with both stiffnesses times a factor."""
        both = (factor * self.normal_kpa_per_mm, factor * self.tangential_kpa_per_mm)
        return replace(self, normal_kpa_per_mm=both[0], tangential_kpa_per_mm=both[1])

    def free_nodes(self, mesh: TetMesh) -> np.ndarray:
        """Numbers (n,) of the nodes that are on no other face of `posterior`."""
        mine = {tuple(face) for face in self.faces.tolist()}
        others = [face for face in mesh.boundaries["posterior"].tolist() if tuple(face) not in mine]
        return np.setdiff1d(self.faces, np.array(others, dtype=self.faces.dtype))

    def on(self, mesh: TetMesh) -> Sliding:
        """Of a mesh whose points are the reference."""
        areas = face_quadrature(mesh.points, self.faces).areas
        stiffness = (self.normal_kpa_per_mm, self.tangential_kpa_per_mm)
        return Sliding(self.faces, areas, mesh.points, self.wall, *stiffness)


@dataclass(frozen=True)
class ChestWall:
    """Ribs that the skin cannot pass, see effects.chest_wall_contact; penalty in kPa/mm."""

    wall: Obstacle
    penalty_kpa_per_mm: float

    def stiffened(self, factor: float) -> "ChestWall":
        """The same with its penalty times a factor."""
        return replace(self, penalty_kpa_per_mm=factor * self.penalty_kpa_per_mm)

    def on(self, mesh: TetMesh) -> Effect:
        """Of a mesh whose points are the reference."""
        return chest_wall_contact(mesh, self.wall, boundary="skin", penalty=self.penalty_kpa_per_mm)


class Part(Protocol):
    """What a body may have beside its bulk: Skin, Fascia, Ligaments, and how it lies on the ribs."""

    def stiffened(self, factor: float) -> "Part":
        """The same with its modulus times a factor."""
        ...

    def on(self, mesh: TetMesh) -> Effect:
        """Its effect on a mesh whose points are the reference."""
        ...


@dataclass(frozen=True)
class Body:
    """What a body is made of, whatever its shape: tissues, and the parts that it has.

    Raises MechanicsError for a tissue of the mesh without parameters, or a part without its boundary.
    """

    tissues: Tissues
    parts: tuple[Part, ...] = ()

    def stiffened(self, factor: float) -> "Body":
        """With every modulus times a factor: it hangs as this one does under its weight over the factor."""
        if factor == 1.0:
            return self
        parts = tuple(part.stiffened(factor) for part in self.parts)
        return replace(self, tissues=_stiffened(self.tissues, factor), parts=parts)

    def held(self, mesh: TetMesh) -> np.ndarray:
        """(n_node, 3) bool: nodes of `posterior` of the mesh, in all components, but of those that slide."""
        held = held_nodes(mesh)
        for part in self.parts:
            if isinstance(part, Slides):
                held[part.free_nodes(mesh)] = False
        return held

    def bulk(self, mesh: TetMesh) -> Effect:
        """The law of the tissues in bulk, on a mesh whose points are the reference."""
        return bulk_tissue(mesh, self.tissues)

    def effects(self, mesh: TetMesh) -> tuple[Effect, ...]:
        """The elastic effects on a mesh whose points are the reference."""
        return (self.bulk(mesh), *(part.on(mesh) for part in self.parts))

    def weight(self, mesh: TetMesh, gravity: np.ndarray) -> Weight:
        """The weight on a mesh whose points are the reference, along the unit vector gravity (3,)."""
        return Weight.of(mesh, self.tissues, gravity)

    def load(
        self,
        mesh: TetMesh,
        gravity: np.ndarray,
        *,
        start: np.ndarray | None = None,
        settings: Settings | None = None,
    ) -> Equilibrium:
        """The equilibrium under gravity, unit vector (3,), of a mesh whose points are stress-free.

        start (n_node, 3) mm: a shape to begin with, by default at rest; settings: of the solver.
        Raises MechanicsError for an ill-posed problem, EquilibriumError when no verified one was reached.
        """
        effects, weight = self.effects(mesh), self.weight(mesh, gravity)
        held = self.held(mesh)
        return equilibrium(mesh, effects, loads=(weight,), start=start, held=held, settings=settings)


def _stiffened(tissues: Tissues, factor: float) -> Tissues:
    if isinstance(tissues, CellTissues):
        return replace(tissues, youngs_modulus_kpa=factor * tissues.youngs_modulus_kpa)
    return {
        label: replace(tissue, youngs_modulus_kpa=factor * tissue.youngs_modulus_kpa)
        for label, tissue in tissues.items()
    }


def body_effects(
    mesh: TetMesh,
    tissues: Tissues,
    *,
    skin: Skin | None = None,
    fascia: Fascia | None = None,
) -> tuple[Effect, ...]:
    """The elastic effects of a body whose mesh.points are the reference: its bulk, and membranes if given.

    Raises MechanicsError for a tissue of the mesh without parameters, or a membrane without its boundary.
    """
    return Body(tissues, tuple(layer for layer in (skin, fascia) if layer is not None)).effects(mesh)


def load(
    mesh: TetMesh,
    tissues: Tissues,
    gravity: np.ndarray,
    *,
    skin: Skin | None = None,
    start: np.ndarray | None = None,
    settings: Settings | None = None,
) -> Equilibrium:
    """The equilibrium under gravity of a body of tissues and skin, see Body.load."""
    parts = () if skin is None else (skin,)
    return Body(tissues, parts).load(mesh, gravity, start=start, settings=settings)


SIDES = ("left", "right")


def is_left(mesh: TetMesh, elements: np.ndarray, middle_mm: float) -> np.ndarray:
    """Which elements (n, m), cells or faces, lie to the left (x > middle_mm by the mean of their nodes)."""
    left: np.ndarray = mesh.points[elements, 0].mean(axis=1) > middle_mm
    return left


def sided_body(
    mesh: TetMesh, tissues: Mapping[str, Tissues], skins: Mapping[str, Skin], *, middle_mm: float
) -> Body:
    """The body of `mesh`, and of the same cells in any other shape, with tissues and skin per side.

    tissues, skins: of `left` and of `right`; the skins differ in nothing but modulus and thickness.
    middle_mm: x of the plane between the sides, in the frame of the mesh.
    Raises MechanicsError for a tissue of the mesh without parameters, or a mesh without skin.
    """
    left = is_left(mesh, mesh.cells, middle_mm)
    one, other = (cell_tissues(mesh, tissues[side]) for side in SIDES)
    names = ("youngs_modulus_kpa", "poisson_ratio", "density_g_cm3")
    both = CellTissues(*(np.where(left, getattr(one, name), getattr(other, name)) for name in names))
    return Body(both, (_sided_skin(mesh, skins, middle_mm),))


def _sided_skin(mesh: TetMesh, skins: Mapping[str, Skin], middle_mm: float) -> Skin:
    left = is_left(mesh, faces_of(mesh, skins["left"].boundary), middle_mm)
    per_face = {
        name: np.where(left, *(getattr(skins[side], name) for side in SIDES))
        for name in ("youngs_modulus_kpa", "thickness_mm")
    }
    return replace(skins["left"], **per_face)
