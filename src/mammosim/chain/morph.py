"""One mesh morphed onto the shape of another: elastic, driven by its surface, free of folds.

The body is an elastic solid, free of stress where it was meshed. Nodes of its skin are drawn to the nearest
points of the target's skin, and nodes of the target's draw their nearest points on the body's, so that
nothing of the target is left out. The attraction starts weak, which moves large parts as wholes, and grows
level by level (in the spirit of Bucki, Lobos & Payan 2010); nearest points are found anew after every
equilibrium. Where a cell comes near folding, the skin's hold on it yields until the whole cell is sound.
"""

import logging
import time
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import ConfigurationError, EquilibriumError, MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.progress import progress
from mammosim.core.settings import require_positive, require_within
from mammosim.core.tissues import Tissue
from mammosim.mechanics.analysis import shared_analysis, system_of
from mammosim.mechanics.effects import Attraction, NeoHookean
from mammosim.mechanics.newton import NewtonSettings, StepFailed, converge
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.reference import smallest_jacobians
from mammosim.meshing.distance import require_boundary, surface_distance

log = logging.getLogger(__name__)

# ASSUME: in a morph the body is homogeneous and nearly keeps its volume, as breasts do: E = 1 kPa, nu = 0.45.
_TISSUE = Tissue(youngs_modulus_kpa=1.0, poisson_ratio=0.45, density_g_cm3=0.0)
# Nearest points change more from one equilibrium to the next than this part of the forces moves the body.
_NEWTON = NewtonSettings(tolerance=1e-3)
# How often a cell may ask for half the hold, before the morph fails.
_YIELDS = 24


@dataclass(frozen=True)
class MorphSettings:
    """stiffness_kpa_per_mm: of the attraction, level by level: the last one is the control of regularity.

    updates: of the nearest points, per level; across: stiffness along the faces over that along their
    normals; drawn, held: the boundaries that are drawn to their like, and those that stay; smallest_J: what
    every cell keeps of its volume, everywhere in it, before the skin's hold on it yields.
    """

    stiffness_kpa_per_mm: tuple[float, ...] = (0.01, 0.03, 0.1, 0.3, 0.7)
    updates: int = 2
    across: float = 0.01
    drawn: tuple[str, ...] = ("skin",)
    held: tuple[str, ...] = ("posterior",)
    smallest_J: float = 0.1

    def __post_init__(self) -> None:
        require_positive(self, "updates", "across")
        require_within("smallest_J", self.smallest_J, 0, 1)
        if not self.stiffness_kpa_per_mm or not min(self.stiffness_kpa_per_mm) > 0:
            raise ConfigurationError(
                f"stiffness_kpa_per_mm = {list(self.stiffness_kpa_per_mm)}: give a level or more, all above 0"
            )


class MorphStep(NamedTuple):
    """The body after one level; the first row is the mesh as it was given, at stiffness 0.

    mean_mm, p95_mm, max_mm: from the nodes of the body's skin to the target's skin; back_...: from the
    target's to the body's; facing_mean_mm, facing_max_mm: of both, without the nodes whose nearest point lies
    on the rim, where the other mesh was cut off; smallest_J: of whole cells; energy_uj: of strain; yielded:
    share of the body's drawn nodes whose hold was weakened; seconds of processor.
    """

    level: int
    stiffness_kpa_per_mm: float
    mean_mm: float
    p95_mm: float
    max_mm: float
    back_mean_mm: float
    back_p95_mm: float
    back_max_mm: float
    facing_mean_mm: float
    facing_max_mm: float
    smallest_J: float
    energy_uj: float
    yielded: float
    seconds: float


@dataclass(frozen=True)
class Morph:
    """points (n_node, 3) mm: the mesh in the target's shape; history: one row per level."""

    points: np.ndarray
    history: tuple[MorphStep, ...]


@shared_analysis()
def morphed(mesh: TetMesh, target: TetMesh, *, settings: MorphSettings | None = None) -> Morph:
    """The mesh in the shape of the target, both in one frame and already close to each other.

    Raises MeshError when a boundary is missing or a cell would fold, EquilibriumError when the body found no
    equilibrium.
    """
    settings = settings or MorphSettings()
    for name in settings.drawn:
        require_boundary(target, name)
    for name in settings.drawn + settings.held:
        require_boundary(mesh, name)
    body = _Body.of(mesh, target, settings)
    x, hold = mesh.points, np.ones(len(mesh.points))
    history = [body.step(x, hold, 0, time.process_time())]
    levels = list(enumerate(settings.stiffness_kpa_per_mm, start=1))
    for level, _ in progress(levels, label="morph", total=len(levels)):
        began = time.process_time()
        for _ in range(settings.updates):
            x, hold = body.drawn(x, hold, level)
        history.append(body.step(x, hold, level, began))
    return Morph(x, tuple(history))


@dataclass(frozen=True)
class Mean:
    """points (n_node, 3) mm; share: of the way from the mesh to the morphed one, 1/2 where nothing folds."""

    points: np.ndarray
    share: float


def sound_mean(mesh: TetMesh, points: np.ndarray) -> Mean:
    """The mean of a mesh and of its nodes at points (n_node, 3); nearer to the mesh where that would fold.

    Raises MeshError when the mesh itself has inverted cells.
    """
    _require_unfolded(mesh)
    share = 0.5
    while share > 1e-3:
        mean = (1 - share) * mesh.points + share * points
        if np.all(smallest_jacobians(mean, mesh.cells) > 0):
            return Mean(mean, share)
        share *= 0.8
    raise MeshError(
        "no mean of mesh and morphed mesh is free of inverted cells; morph with a larger smallest_J"
    )


@dataclass(frozen=True)
class _Body:
    """What does not change in a morph: reference, target, cell volumes, elastic energy, held nodes."""

    mesh: TetMesh
    target: TetMesh
    settings: MorphSettings
    volumes: np.ndarray
    bulk: NeoHookean
    held: np.ndarray

    @classmethod
    def of(cls, mesh: TetMesh, target: TetMesh, settings: MorphSettings) -> "_Body":
        volumes = _require_unfolded(mesh)
        bulk = NeoHookean.of(mesh, dict.fromkeys(Label, _TISSUE))
        held = np.zeros(mesh.points.shape, dtype=bool)
        for name in settings.held:
            held[mesh.boundary_nodes(name)] = True
        return cls(mesh, target, settings, volumes, bulk, held)

    def drawn(self, x: np.ndarray, hold: np.ndarray, level: int) -> tuple[np.ndarray, np.ndarray]:
        """The shape in equilibrium with the nearest points of shape x, and the hold that is left there."""
        stiffness = self.settings.stiffness_kpa_per_mm[level - 1]
        full = [
            _attraction(self.mesh.moved_to(x), self.target, name, stiffness, self.settings.across)
            for name in self.settings.drawn
        ]
        hold = hold.copy()
        for _ in range(_YIELDS):
            pulls = tuple(replace(a, stiffness=a.stiffness * hold[a.nodes].min(axis=1)) for a in full)
            new = self._settled(x, pulls)
            folding = self.ratios(new) < self.settings.smallest_J
            if not folding.any():
                return new, hold
            hold[np.unique(self.mesh.cells[folding])] /= 2
        raise MeshError(
            f"at {stiffness:g} kPa/mm the morph folds {folding.sum()} of {len(folding)} cells, the first "
            f"{np.flatnonzero(folding)[0]}: they keep less than smallest_J = {self.settings.smallest_J:g} of "
            "their volume; end with a lower stiffness_kpa_per_mm, or give a finer mesh"
        )

    def _settled(self, x: np.ndarray, pulls: tuple[Attraction, ...]) -> np.ndarray:
        with system_of(Potential((self.bulk, *pulls)), self.held) as system:
            try:
                return converge(system, x, _NEWTON, [])
            except StepFailed as failure:
                raise EquilibriumError(
                    f"the morph found no equilibrium: {failure}; give more levels of stiffness_kpa_per_mm, "
                    "or bring the two meshes nearer to each other"
                ) from failure

    def ratios(self, x: np.ndarray) -> np.ndarray:
        """(n_cell,): the smallest Jacobian of each whole cell over that of the reference."""
        found: np.ndarray = smallest_jacobians(x, self.mesh.cells) / self.volumes
        return found

    def step(self, x: np.ndarray, hold: np.ndarray, level: int, began: float) -> MorphStep:
        """The row of the history."""
        name, body = self.settings.drawn[0], self.mesh.moved_to(x)
        there = surface_distance(body, self.target, boundary=name)
        back = surface_distance(self.target, body, boundary=name)
        own, theirs = _Nearest.of(body, self.target, name), _Nearest.of(self.target, body, name)
        facing = np.concatenate([there[own.faces_it], back[theirs.faces_it]])
        stiffness = self.settings.stiffness_kpa_per_mm[level - 1] if level else 0.0
        log.info("morph at %g kPa/mm: mean %.3f mm, max %.3f mm", stiffness, there.mean(), there.max())
        return MorphStep(
            level,
            stiffness,
            mean_mm=there.mean(),
            p95_mm=np.percentile(there, 95),
            max_mm=there.max(),
            back_mean_mm=back.mean(),
            back_p95_mm=np.percentile(back, 95),
            back_max_mm=back.max(),
            facing_mean_mm=facing.mean(),
            facing_max_mm=facing.max(),
            smallest_J=self.ratios(x).min(),
            energy_uj=self.bulk.energy(x),
            yielded=float(np.mean(hold[body.boundary_nodes(name)] < 1)),
            seconds=time.process_time() - began,
        )


@dataclass(frozen=True)
class _Nearest:
    """Nodes (n,) of one mesh's boundary, ascending, their nearest points on the other's, areas (n,) mm2.

    faces_it (n,): whether that point is inside the other's boundary, not on its rim.
    """

    nodes: np.ndarray
    points: MaterialPoints
    areas: np.ndarray
    faces_it: np.ndarray

    @classmethod
    def of(cls, mesh: TetMesh, other: TetMesh, boundary: str) -> "_Nearest":
        nodes = mesh.boundary_nodes(boundary)
        points = MaterialPoints.on(other, mesh.points[nodes], boundary=boundary)
        inside = ~np.isin(points.nodes, _rim(other.boundaries[boundary]))
        faces_it = np.sum(np.abs(points.weights) * inside, axis=1) > 1e-6
        return cls(nodes, points, _node_areas(mesh, boundary), faces_it)


# ASSUME: meshes are cut off at slightly different places: what lies beyond the other's rim is not drawn.
def _attraction(body: TetMesh, target: TetMesh, name: str, stiffness: float, across: float) -> Attraction:
    """Of the body's nodes to the target's faces, and of the body's faces to the target's nodes."""
    faces = body.boundaries[name]
    own, theirs = _Nearest.of(body, target, name), _Nearest.of(target, body, name)
    _, first = np.unique(faces, return_index=True)
    keep = np.concatenate([own.faces_it, theirs.faces_it])
    return Attraction(
        faces,
        np.concatenate([first // 6, theirs.points.face])[keep],
        np.vstack([np.eye(6)[first % 6], theirs.points.weights])[keep],
        np.vstack([own.points.carry(target.points), target.points[theirs.nodes]])[keep],
        np.vstack([own.points.normals(target.points), theirs.points.normals(body.points)])[keep],
        stiffness * np.concatenate([own.areas, theirs.areas])[keep],
        across,
    )


def _rim(faces: np.ndarray) -> np.ndarray:
    """Nodes of the edges that belong to one face only."""
    middles, count = np.unique(faces[:, 3:], return_counts=True)
    single = np.isin(faces[:, 3:], middles[count == 1])
    ends = np.stack([faces[:, :3], np.roll(faces[:, :3], -1, axis=1), faces[:, 3:]], axis=-1)
    return np.unique(ends[single])


def _node_areas(mesh: TetMesh, boundary: str) -> np.ndarray:
    """A (n,) mm2 of each node of a boundary, numbers ascending: a sixth of each of its faces."""
    faces = mesh.boundaries[boundary]
    a, b, c = (mesh.points[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    A = np.bincount(faces.ravel(), np.repeat(area / 6, 6), minlength=len(mesh.points))
    found: np.ndarray = A[np.unique(faces)]
    return found


def _require_unfolded(mesh: TetMesh) -> np.ndarray:
    """The smallest Jacobians (n_cell,) mm3 of a mesh. Raises MeshError when a cell is inverted."""
    J = smallest_jacobians(mesh.points, mesh.cells)
    bad = np.flatnonzero(J <= 0)
    if len(bad):
        raise MeshError(f"the mesh has {len(bad)} inverted cells, the first {bad[0]}: mesh again, then morph")
    return J
