"""From a label map to the mesh of the tissue that deforms."""

import logging
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from mammosim.core.errors import MeshError
from mammosim.core.labels import DEFORMABLE, LEAST_PIECE, Label
from mammosim.core.mesh import TetMesh
from mammosim.core.units import MM3_PER_CM3
from mammosim.core.volume import Grid, LabelMap
from mammosim.meshing.boundary import named_boundaries
from mammosim.meshing.lattice import LENGTH_MM, on_lattice
from mammosim.meshing.quality import quality, require_sound
from mammosim.meshing.raster import rasterise
from mammosim.meshing.remesh import Size
from mammosim.meshing.surface import surface_of_labels
from mammosim.meshing.tetrahedra import mesh_surface

log = logging.getLogger(__name__)

PERCENT = 100.0
# ASSUME: tissue within 20 mm of the rib cage is chest wall and gets its larger elements.
# ASSUME: between 20 and 40 mm from the rib cage the element size changes linearly to that of the breast.
CHEST_MM, CHANGE_MM = 20.0, 20.0
# ASSUME: elements up to 1.2 times as long as a layer is thick follow it well enough.
PER_THICKNESS = 1.2
# Voxels finer than this fraction of the smallest element are thinned out before the surface is built.
VOXELS_PER_ELEMENT = 6
TOLD = 0.01  # of the volume of the labels, above which an error of the mesh is a warning
# Far above the rounding of a voxel's place, far below what a limit is known to.
ON_LIMIT_MM = 1e-4


@dataclass(frozen=True)
class ElementSize:
    """Edge lengths in mm: breast_mm far from the rib cage, chest_mm next to it.

    Raises MeshError unless both lie in [2, 50] mm.
    """

    breast_mm: float
    chest_mm: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 2 <= value <= 50:
                raise MeshError(
                    f"{name} = {value:g} is outside [2, 50] mm; 12 suits a breast: was it given in cm?"
                )

    @property
    def least_mm(self) -> float:
        """Edge length of the smallest elements, where tissue is thin."""
        return min(self.breast_mm, self.chest_mm) / 2


def mesh_body(labels: LabelMap, *, size: ElementSize) -> TetMesh:
    """Mesh the DEFORMABLE voxels of labels (nz, ny, nx), with elements of a size in mm.

    Returns quadratic tetrahedra in the frame of the labels, with tissue and boundaries: `skin`, `posterior`.
    They fill the largest piece, and any that is at least LEAST_PIECE times as large: two breasts that nothing
    joins. Each piece encloses the volume of its voxels, cavities filled. The shares of its cells are those of
    the deformable voxels in them. Raises MeshError when there is nothing to mesh, or the mesh is not
    sound. The cells depend on the grid's spacing to LENGTH_MM, as on the sizes, and not on where it lies:
    it is meshed along its own axes.
    """
    size = ElementSize(*(float(on_lattice(length, LENGTH_MM)) for length in vars(size).values()))
    upright = LabelMap(_upright(labels.grid), labels.values)
    mesh = _joined([_meshed(piece, size) for piece in _pieces(upright)])
    coarse = _thinned(upright, _step_mm(size))
    shares = shares_of_cells(mesh, upright)
    tissue = shares.argmax(axis=1).astype(np.uint8)
    mesh = replace(mesh, tissue=tissue, shares=shares, boundaries=named_boundaries(mesh, coarse))
    require_sound(mesh)
    return mesh.moved_to(_placed(upright.grid.indices(mesh.points), labels.grid))


def _meshed(labels: LabelMap, size: ElementSize) -> TetMesh:
    """The mesh of labels with one piece of DEFORMABLE voxels, which has their volume."""
    coarse = _thinned(labels, _step_mm(size))
    soft = np.isin(labels.values, DEFORMABLE)
    place = ndimage.find_objects(soft.astype(np.uint8))[0]
    volume = np.count_nonzero(ndimage.binary_fill_holes(soft[place])) * labels.grid.voxel_volume
    mesh = mesh_surface(
        surface_of_labels(coarse),
        size=_size_by_depth(coarse, size),
        volume_mm3=volume,
        most_mm=float(coarse.grid.spacing.max()) / 2,
    )
    error = quality(mesh)["volume_mm3"].sum() / volume - 1
    log.log(
        logging.INFO if abs(error) < TOLD else logging.WARNING,
        "%.1f cm3 of tissue in a mesh of %+.2f %%", volume / MM3_PER_CM3, PERCENT * error,
    )  # fmt: skip
    return mesh


def thin_volume(labels: LabelMap, size: ElementSize) -> float:
    """Volume in mm3 of the DEFORMABLE voxels whose tissue is thinner along some axis than any element."""
    soft, step = np.isin(labels.values, DEFORMABLE), labels.grid.spacing[::-1]
    thin = np.zeros_like(soft)
    for axis, length in enumerate(step):
        thin |= soft & (np.moveaxis(_run(np.moveaxis(soft, axis, -1)), -1, axis) * length < size.least_mm)
    return float(np.count_nonzero(thin) * labels.grid.voxel_volume)


def _run(mask: np.ndarray) -> np.ndarray:
    """How many voxels (.., n) of a mask follow each other along its last axis, where it is true."""
    n = mask.shape[-1]
    place = np.arange(n, dtype=np.int16)
    before = np.maximum.accumulate(np.where(mask, np.int16(-1), place), axis=-1)
    after = np.minimum.accumulate(np.where(mask, np.int16(n), place)[..., ::-1], axis=-1)[..., ::-1]
    length: np.ndarray = after - before - 1
    return length


def _step_mm(size: ElementSize) -> float:
    """How far apart voxels may be."""
    return min(size.breast_mm, size.chest_mm) / VOXELS_PER_ELEMENT


def _pieces(labels: LabelMap) -> list[LabelMap]:
    """Labels with air in the place of all but one piece of tissue, for every large one, the largest first."""
    pieces, n = ndimage.label(np.isin(labels.values, DEFORMABLE))
    if n < 2:
        return [labels]
    size = np.bincount(pieces.ravel())
    size[0] = 0
    kept = np.argsort(-size, kind="stable")[: np.count_nonzero(size >= LEAST_PIECE * size.max())]
    others = [(pieces > 0) & (pieces != piece) for piece in kept]
    return [replace(labels, values=np.where(other, np.uint8(Label.AIR), labels.values)) for other in others]


def _joined(meshes: list[TetMesh]) -> TetMesh:
    """Meshes that share no node as one."""
    first = np.cumsum([0, *(len(mesh.points) for mesh in meshes[:-1])])
    return TetMesh(
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([mesh.cells + n for mesh, n in zip(meshes, first)]),
        np.concatenate([mesh.tissue for mesh in meshes]),
    )


def crop_body(
    labels: LabelMap, *, posterior_limit_mm: float, height_limits_mm: tuple[float, float]
) -> LabelMap:
    """Deformable voxels with y beyond the limit, or z outside the two limits, become THORAX.

    Limits in the patient frame of the labels' grid. The cut is thereby held, as the chest wall is. A voxel
    whose centre lies on a limit, or beyond it by less than ON_LIMIT_MM, is kept.
    """
    k, j, i = np.ogrid[tuple(slice(n) for n in labels.grid.shape)]
    steps = labels.grid.direction * labels.grid.spacing
    _, y, z = (o + s[0] * i + s[1] * j + s[2] * k for o, s in zip(labels.grid.origin, steps))
    low, high = height_limits_mm[0] - ON_LIMIT_MM, height_limits_mm[1] + ON_LIMIT_MM
    beyond = (y > posterior_limit_mm + ON_LIMIT_MM) | (z < low) | (z > high)
    cut = beyond & np.isin(labels.values, DEFORMABLE)
    return LabelMap(labels.grid, np.where(cut, np.uint8(Label.THORAX), labels.values))


def shares_of_cells(mesh: TetMesh, labels: LabelMap) -> np.ndarray:
    """The share (n_cell, len(Label)) of each label in the deformable voxels of a cell.

    A cell without any is wholly of the nearest one's label.
    """
    # ASSUME: skin voxels count as adipose in the volume, since the skin is a membrane on the surface.
    tissue = np.where(labels.values == Label.SKIN, np.uint8(Label.ADIPOSE), labels.values)
    raster = rasterise(mesh, labels.grid)
    counted = raster.inside & np.isin(tissue, DEFORMABLE)
    n = len(Label)
    votes = np.bincount(raster.cell[counted] * n + tissue[counted], minlength=len(mesh.cells) * n)
    votes = votes.reshape(-1, n)
    empty = votes.sum(axis=1) == 0
    if empty.any():
        centres = mesh.points[mesh.cells[empty, :4]].mean(axis=1)
        votes[empty, _nearest_deformable(tissue, labels.grid, centres)] = 1
    return votes / votes.sum(axis=1, keepdims=True)


def _nearest_deformable(tissue: np.ndarray, grid: Grid, points: np.ndarray) -> np.ndarray:
    """Label (n,) of the deformable voxel nearest to the voxel of each point (n, 3)."""
    nearest = ndimage.distance_transform_edt(
        ~np.isin(tissue, DEFORMABLE), sampling=grid.spacing[::-1], return_distances=False, return_indices=True
    )
    voxel = np.clip(np.rint(grid.indices(points)).astype(int), 0, np.array(grid.shape) - 1)
    return tissue[tuple(nearest[:, *voxel.T])]


def _upright(grid: Grid) -> Grid:
    """The grid from the origin along x, y and z, or -z when it is left-handed, spacing rounded to LENGTH_MM.

    Planes of voxels are exactly planes there, and products with its direction are exact.
    """
    i, j, k = grid.direction.T
    handed = np.sign(np.sum(np.cross(i, j) * k))
    spacing = on_lattice(grid.spacing, LENGTH_MM)
    return Grid(grid.shape, spacing, np.zeros(3), np.diag([1.0, 1.0, handed]))


def _placed(indices: np.ndarray, grid: Grid) -> np.ndarray:
    """Points (n, 3) of continuous array indices (n, 3) in a grid, summed in the same order everywhere."""
    k, j, i = indices.T[:, :, None]
    steps = grid.direction.T * grid.spacing[:, None]
    return grid.origin + (i * steps[0] + j * steps[1] + k * steps[2])


def _thinned(labels: LabelMap, step_mm: float) -> LabelMap:
    """Every n-th voxel along each axis, at most step_mm apart."""
    n = np.maximum(np.floor(step_mm / labels.grid.spacing + 1e-5).astype(int), 1)
    values = labels.values[:: n[2], :: n[1], :: n[0]]
    return LabelMap(replace(labels.grid, shape=values.shape, spacing=labels.grid.spacing * n), values)


def _size_by_depth(labels: LabelMap, size: ElementSize) -> Size:
    """Edge length by the distance from the thorax, but nowhere much larger than the tissue is thick there."""
    step = labels.grid.spacing[::-1]
    wanted = np.full(labels.grid.shape, size.breast_mm, dtype=np.float32)
    thorax = labels.values == Label.THORAX
    if thorax.any():
        depth = ndimage.distance_transform_edt(~thorax, sampling=step)
        wanted[:] = np.interp(depth, [CHEST_MM, CHEST_MM + CHANGE_MM], [size.chest_mm, size.breast_mm])
    within = ndimage.distance_transform_edt(np.isin(labels.values, DEFORMABLE), sampling=step)
    # Half the thickness is the largest distance from the outside in a neighbourhood as wide as an element.
    width = 2 * np.ceil(max(size.breast_mm, size.chest_mm) / 2 / step).astype(int) + 1
    thickness = 2 * ndimage.maximum_filter(within, size=tuple(width))
    field = np.clip(PER_THICKNESS * thickness, size.least_mm, wanted).astype(np.float32)
    return lambda points: ndimage.map_coordinates(
        field, labels.grid.indices(points).T, order=1, mode="nearest"
    ).astype(float)
