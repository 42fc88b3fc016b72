"""Bodies of the hard cases: simple shapes, stretched, carved, covered with a thin layer, spoilt on purpose.

The chest wall is the plane z = 0, where `posterior` lies; z points outward.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np

from mammosim.core.errors import ConfigurationError, MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.core.settings import Count, Limits, OneOf, Settings, Triple
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.quality import quality
from mammosim.meshing.shapes import ball_part, box, with_layer

Length = Annotated[float, Limits(above=0, at_most=1000, advice="in mm: was it given in m?")]
# Nodes of a quadratic tetrahedron with two vertices exchanged: its mirror image.
MIRRORED = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]
_SPOILT = 3  # how many elements a defect spoils


@dataclass(frozen=True)
class Slivers(Settings):
    """How many elements are squeezed, to which part of their height."""

    count: Annotated[int, Limits(at_least=1, at_most=1000)]
    height: Annotated[float, Limits(at_least=0, at_most=1)]


@dataclass(frozen=True)
class Lump(Settings):
    """A ball of LESION in the body at rest: the cells whose middle lies in it."""

    centre_mm: Triple
    radius_mm: Length

    def holds(self, middles: np.ndarray) -> np.ndarray:
        """Which of middles (n, 3) mm lie in it, (n,)."""
        return np.asarray(np.linalg.norm(middles - self.centre_mm, axis=1) < self.radius_mm)


@dataclass(frozen=True, kw_only=True)
class Shape(Settings):
    """stretched: factors of x, y, z; leaning: how far x and y go with z, mm/mm, after that.

    layer_mm: of solid SKIN, outside; muscle_mm: below this z a cell is MUSCLE; lumps: of LESION, in what is
    stretched and leans; defect: a name of DEFECTS.
    """

    layer_mm: Annotated[float, Limits(at_least=0, at_most=10)] = 0.0
    stretched: Triple | None = None
    leaning: tuple[float, float] = (0.0, 0.0)
    muscle_mm: Annotated[float, Limits(at_least=0, at_most=1000)] = 0.0
    lumps: tuple[Lump, ...] = ()
    slivers: Slivers | None = None
    defect: str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.defect is not None and self.defect not in DEFECTS:
            raise ConfigurationError(f"unknown defect {self.defect!r}; choose one of: {', '.join(DEFECTS)}")

    def unspoilt(self) -> TetMesh:
        """As it is before it is stretched or spoilt."""
        raise NotImplementedError

    def mesh(self) -> TetMesh:
        """The body at rest. Raises MeshError where it cannot be spoilt like that."""
        mesh = self.unspoilt()
        if self.stretched is not None:
            mesh = mesh.moved_to(mesh.points * self.stretched)
        mesh = mesh.moved_to(mesh.points + mesh.points[:, 2:] * [*self.leaning, 0.0])
        mesh = replace(mesh, tissue=self._labels(mesh))
        if self.slivers is not None:
            mesh = with_slivers(mesh, count=self.slivers.count, height=self.slivers.height)
        return DEFECTS[self.defect](mesh) if self.defect else mesh

    def _labels(self, mesh: TetMesh) -> np.ndarray:
        """(n_cell,) of muscle below, lumps, and what it was elsewhere."""
        middles = middles_of(mesh)
        labels = np.where(middles[:, 2] < self.muscle_mm, int(Label.MUSCLE), mesh.tissue)
        for lump in self.lumps:
            labels = np.where(lump.holds(middles), int(Label.LESION), labels)
        return labels

    def refined(self, edge_mm: float) -> Self:
        """The same body with elements of edge_mm. Raises ConfigurationError where there is no such thing."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class Ball(Shape):
    """Half of a ball of outer radius radius_mm, or an octant, with the layer on the sphere."""

    radius_mm: Length
    edge_mm: Length
    octant: bool = False

    def unspoilt(self) -> TetMesh:
        inner = self.radius_mm - self.layer_mm
        mesh = ball_part(inner, self.edge_mm, octant=self.octant)
        return with_layer(mesh, mesh.points * (self.radius_mm / inner)) if self.layer_mm else mesh

    def refined(self, edge_mm: float) -> Self:
        return replace(self, edge_mm=edge_mm)


@dataclass(frozen=True)
class Staircase(Settings):
    """The largest half ellipsoid in the box, as voxels have it."""

    def keeps(self, middles: np.ndarray, size: np.ndarray) -> np.ndarray:
        """Which bricks with middles (n, 3) of a box of size (3,) mm remain, (n,)."""
        from_base = (middles - size * [0.5, 0.5, 0.0]) / (size * [0.5, 0.5, 1.0])
        return np.asarray(np.linalg.norm(from_base, axis=1) < 1)


@dataclass(frozen=True)
class Slot(Settings):
    """All but the bricks between two corners."""

    low_mm: Triple
    high_mm: Triple

    def keeps(self, middles: np.ndarray, size: np.ndarray) -> np.ndarray:
        """As Staircase."""
        return ~np.all((middles > self.low_mm) & (middles < self.high_mm), axis=1)


@dataclass(frozen=True, kw_only=True)
class Brick(Shape):
    """A box of so many bricks, size without the layer on its top; carved: which of them remain."""

    counts: tuple[Count, Count, Count]
    size_mm: tuple[Length, Length, Length]
    carved: Annotated[Staircase | Slot, OneOf({"staircase": Staircase, "slot": Slot})] | None = None

    def unspoilt(self) -> TetMesh:
        mesh = box(self.counts, self.size_mm)
        if self.carved is not None:
            size = np.array(self.size_mm)
            step = size / self.counts
            bricks = (np.floor(middles_of(mesh) / step) + 0.5) * step
            mesh = with_cells(mesh, self.carved.keeps(bricks, size))
        if not self.layer_mm:
            return mesh
        skin = mesh.boundaries["skin"]
        top = skin[np.all(np.isclose(mesh.points[skin][:, :, 2], self.size_mm[2]), axis=1)]
        covered = replace(mesh, boundaries={**mesh.boundaries, "top": top})
        return with_layer(covered, mesh.points + [0.0, 0.0, self.layer_mm], boundary="top")

    def refined(self, edge_mm: float) -> Self:
        if self.carved is not None:
            raise ConfigurationError("finer bricks carve another body; use another reference than refined")
        counts = np.ceil(np.array(self.size_mm) / edge_mm).astype(int)
        return replace(self, counts=tuple(counts.tolist()))


def middles_of(mesh: TetMesh) -> np.ndarray:
    """(n_cell, 3) mm: the means of the vertices of each cell."""
    middles: np.ndarray = mesh.points[mesh.cells[:, :4]].mean(axis=1)
    return middles


def with_cells(mesh: TetMesh, kept: np.ndarray) -> TetMesh:
    """The cells kept (n_cell,) of a mesh; `skin` are the faces on their outside that are not `posterior`."""
    nodes, cells = np.unique(mesh.cells[kept], return_inverse=True)
    points, cells = mesh.points[nodes], cells.reshape(-1, 10)
    outer = boundary_faces(cells)
    held = np.isin(nodes[outer], mesh.boundary_nodes("posterior")).all(axis=1)
    return TetMesh(points, cells, mesh.tissue[kept], {"posterior": outer[held], "skin": outer[~held]})


def with_slivers(mesh: TetMesh, *, count: int, height: float) -> TetMesh:
    """The mesh with `count` elements squeezed to a part of their height, none beside another.

    An inner vertex v goes to c + height (v - c), c the middle of the opposite face; its edges are straight.
    Raises MeshError when fewer elements can be squeezed without inverting their neighbours.
    """
    outer = np.concatenate([faces.ravel() for faces in mesh.boundaries.values()])
    taken = np.isin(np.arange(len(mesh.points)), outer)
    found = 0
    for number, cell in enumerate(mesh.cells):
        if found == count or taken[cell[0]]:
            continue
        c = mesh.points[cell[1:4]].mean(axis=0)
        around = np.flatnonzero((mesh.cells[:, :4] == cell[0]).any(axis=1))
        squeezed = _with_vertex_at(mesh, cell[0], c + height * (mesh.points[cell[0]] - c), around)
        beside = around[around != number]
        neighbours = replace(squeezed, cells=mesh.cells[beside], tissue=mesh.tissue[beside])
        if quality(neighbours)["smallest_J"].gt(0).all():
            mesh, found = squeezed, found + 1
            taken[mesh.cells[around]] = True
    if found < count:
        raise MeshError(f"only {found} of {count} elements can be squeezed to {height:g}: use a finer mesh")
    return mesh


def _with_vertex_at(mesh: TetMesh, vertex: int, place: np.ndarray, around: np.ndarray) -> TetMesh:
    points = mesh.points.copy()
    points[vertex] = place
    a, b = mesh.cells[around][:, np.array(EDGES)].transpose(2, 0, 1)
    moved = (a == vertex) | (b == vertex)
    points[mesh.cells[around, 4:][moved]] = (points[a[moved]] + points[b[moved]]) / 2
    return mesh.moved_to(points)


def _inverted(mesh: TetMesh) -> TetMesh:
    cells = mesh.cells.copy()
    cells[:_SPOILT] = cells[:_SPOILT, MIRRORED]
    return replace(mesh, cells=cells)


def _flat(mesh: TetMesh) -> TetMesh:
    """Elements without volume: their vertices lie in one plane."""
    return with_slivers(mesh, count=_SPOILT, height=0.0)


def _unattached(mesh: TetMesh) -> TetMesh:
    other = box((1, 1, 1), (5.0, 5.0, 5.0))
    return replace(
        mesh,
        points=np.vstack([mesh.points, other.points + [0.0, 0.0, 2 * np.ptp(mesh.points)]]),
        cells=np.vstack([mesh.cells, other.cells + len(mesh.points)]),
        tissue=np.concatenate([mesh.tissue, other.tissue]),
    )


def _not_a_number(mesh: TetMesh) -> TetMesh:
    points = mesh.points.copy()
    points[:_SPOILT, 1] = np.nan
    return mesh.moved_to(points)


def _loose_node(mesh: TetMesh) -> TetMesh:
    return mesh.moved_to(np.vstack([mesh.points, [[0.0, 0.0, 1e3]]]))


def _without_posterior(mesh: TetMesh) -> TetMesh:
    return replace(mesh, boundaries={"skin": mesh.boundaries["skin"]})


def _unknown_tissue(mesh: TetMesh) -> TetMesh:
    tissue = mesh.tissue.copy()
    tissue[:_SPOILT] = int(Label.GLANDULAR)
    return replace(mesh, tissue=tissue)


DEFECTS: Mapping[str, Callable[[TetMesh], TetMesh]] = {
    "inverted": _inverted,
    "flat": _flat,
    "unattached": _unattached,
    "not_a_number": _not_a_number,
    "loose_node": _loose_node,
    "without_posterior": _without_posterior,
    "unknown_tissue": _unknown_tissue,
}
