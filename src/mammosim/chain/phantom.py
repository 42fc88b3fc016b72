"""The compressed breast as voxels, each carried back to where it was measured to take its tissue there."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import ndimage
from scipy.spatial import cKDTree

from mammosim.core.errors import MeshError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.mesh import EDGES, SUBTETRAHEDRA, SUBTRIANGLES, TetMesh
from mammosim.core.units import MM3_PER_CM3
from mammosim.core.volume import Grid, LabelMap, grid_around
from mammosim.mechanics.reference import (
    TETRAHEDRON,
    TETRAHEDRON_POINTS,
    shape_functions,
    shape_gradients,
)
from mammosim.meshing.raster import rasterise

# Barycentric coordinates (10, 4) of the nodes of a quadratic tetrahedron.
NODES = np.vstack([np.eye(4), [(np.eye(4)[a] + np.eye(4)[b]) / 2 for a, b in EDGES]])


@dataclass(frozen=True)
class MaterialVolume:
    """Sample points of a body: cell (n,), N (n_point, 10) per cell, dV and dv (n,) mm3 in its two shapes."""

    cell: np.ndarray
    N: np.ndarray
    dV: np.ndarray
    dv: np.ndarray

    def carry(self, mesh: TetMesh, points: np.ndarray) -> np.ndarray:
        """Where the sample points are, (n, 3), when the nodes of `mesh` are at points (n_node, 3)."""
        found: np.ndarray = np.einsum("qa,cad->cqd", self.N, points[mesh.cells]).reshape(-1, 3)
        return found


def material_volume(mesh: TetMesh, reference: np.ndarray) -> MaterialVolume:
    """32 points in each cell, 4 in each of its 8 parts, which resolve sharp borders: a box, a label.

    mesh: in its deformed shape x; reference: X (n_node, 3) mm. dV = w det(dX/dxi), dv = w det(dx/dxi): the
    sum of dv over a part of the body is the integral of J dV.
    """
    parts = NODES[np.array(SUBTETRAHEDRA)]
    L = np.einsum("qv,svd->sqd", TETRAHEDRON_POINTS, parts).reshape(-1, 4)
    N, dN = shape_functions(L, TETRAHEDRON), shape_gradients(L, TETRAHEDRON)
    weight = 1 / 6 / len(L)
    dV, dv = (
        weight * np.linalg.det(np.einsum("cad,qae->cqde", shape[mesh.cells], dN)).ravel()
        for shape in (reference, mesh.points)
    )
    return MaterialVolume(np.repeat(np.arange(len(mesh.cells)), len(L)), N, dV, dv)


# ASSUME: under the skin, voxels segmented as skin are fat: the segmented skin is one image voxel thick.
GROUPS: Mapping[str, tuple[Label, ...]] = {
    "all": DEFORMABLE,
    "glandular": (Label.GLANDULAR,),
    "adipose and skin": (Label.ADIPOSE, Label.SKIN),
    "muscle": (Label.MUSCLE,),
}
PLATE_MARGIN_MM = 3.0


@dataclass(frozen=True)
class Lesion:
    """A ball of tumour in the measured shape: centre (3,) mm in the measured frame, radius in mm.

    Raises MeshError unless the radius is positive.
    """

    centre: np.ndarray
    radius_mm: float

    def __post_init__(self) -> None:
        if not self.radius_mm > 0:
            raise MeshError(f"lesion radius {self.radius_mm:g} mm must be positive; 2 to 10 mm is usual")

    @classmethod
    def behind(
        cls, nipple: np.ndarray, *, inwards: np.ndarray, depth_mm: float, diameter_mm: float
    ) -> "Lesion":
        """A lesion whose centre is depth_mm straight behind a nipple (3,), along `inwards` (3,)."""
        return cls(nipple + depth_mm * inwards / np.linalg.norm(inwards), diameter_mm / 2)

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) lie inside, (n,) bool."""
        found: np.ndarray = np.linalg.norm(points - self.centre, axis=1) <= self.radius_mm
        return found

    @property
    def volume_mm3(self) -> float:
        """4/3 pi r^3."""
        return 4 / 3 * np.pi * self.radius_mm**3


def field_box(
    side: str, *, midline_mm: float, chest_wall_mm: float, bottom_mm: float, top_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (3,) of what lies in a craniocaudal X-ray field: one breast between the plates.

    side: 'left' (x above midline_mm) or 'right'; chest_wall_mm: y of the field's edge at the chest wall;
    bottom_mm, top_mm: z of the faces of the plates. The box is PLATE_MARGIN_MM higher and lower than these,
    so that skin which the contact lets into a plate still has air outside.
    """
    # ASSUME: the X-ray field ends at the midline and at the edge of the plates.
    bottom, top = bottom_mm - PLATE_MARGIN_MM, top_mm + PLATE_MARGIN_MM
    low = np.array([midline_mm if side == "left" else -np.inf, -np.inf, bottom])
    high = np.array([np.inf if side == "left" else midline_mm, chest_wall_mm, top])
    return low, high


def field_grid(mesh: TetMesh, low: np.ndarray, high: np.ndarray, *, voxel_mm: float) -> Grid:
    """Voxels of the part of the mesh inside the box low (3,) to high (3,) mm, which may be infinite.

    Where the mesh ends inside the box the grid goes one voxel further, so that there is air around it.
    Raises MeshError when nothing of the mesh is in the box.
    """
    inside = np.all((mesh.points >= low) & (mesh.points <= high), axis=1)
    if not inside.any():
        raise MeshError(
            f"no tissue between {np.round(low, 1)} and {np.round(high, 1)} mm; the mesh reaches from "
            f"{np.round(mesh.points.min(0), 1)} to {np.round(mesh.points.max(0), 1)}: move the X-ray field"
        )
    body = mesh.points[inside]
    return grid_around(
        np.maximum(body.min(0) - voxel_mm, low), np.minimum(body.max(0) + voxel_mm, high), voxel_mm
    )


def voxel_breast(
    mesh: TetMesh, measured: np.ndarray, segmentation: LabelMap, *, grid: Grid, skin_mm: float
) -> LabelMap:
    """Tissue of every voxel of the deformed breast, air outside; only its largest connected piece.

    mesh: deformed; measured: (n_node, 3) its nodes in the frame and the shape of `segmentation`.
    The outermost skin_mm are skin, measured from the boundary 'skin'.
    Raises MeshError when no voxel of the grid lies in the mesh.
    """
    raster = rasterise(mesh, grid)
    inside = raster.cell >= 0
    if not inside.any():
        raise MeshError("no voxel of the grid lies inside the mesh; use smaller voxels or another field")
    labels = np.zeros(grid.shape, np.uint8)
    labels[inside] = tissue_at(segmentation, raster.carry(measured), mesh.tissue[raster.cell[inside]])
    labels[labels == Label.SKIN] = Label.ADIPOSE
    labels[inside & (skin_depth(mesh, inside, grid) <= skin_mm)] = Label.SKIN
    pieces, _ = ndimage.label(inside)
    labels[pieces != np.argmax(np.bincount(pieces[inside]))] = Label.AIR
    return LabelMap(grid, labels)


def with_lesion(
    phantom: LabelMap,
    mesh: TetMesh,
    measured: np.ndarray,
    lesion: Lesion,
    *,
    kept: tuple[Label, ...] = (Label.SKIN,),
) -> LabelMap:
    """The phantom with the lesion, which has moved with the tissue from the measured to the deformed shape.

    Voxels of the labels `kept` stay what they are. Raises MeshError when no voxel is in the lesion.
    """
    raster = rasterise(mesh, phantom.grid)
    hit = np.zeros(phantom.values.shape, bool)
    hit[raster.cell >= 0] = lesion.holds(raster.carry(measured))
    hit &= (phantom.values != Label.AIR) & ~np.isin(phantom.values, kept)
    if not hit.any():
        raise MeshError(
            f"no voxel in the lesion of radius {lesion.radius_mm:g} mm at {np.round(lesion.centre, 1)} mm; "
            "move it into the breast (depth_mm), or enlarge it beyond the voxel size"
        )
    return LabelMap(phantom.grid, np.where(hit, Label.LESION, phantom.values).astype(np.uint8))


def healthy(phantom: LabelMap) -> LabelMap:
    """The phantom without its lesion, whose voxels take the tissue nearest to them."""
    # ASSUME: without the lesion, its place is filled by the nearest tissue around it.
    lesion = phantom.values == Label.LESION
    nearest = ndimage.distance_transform_edt(lesion, return_distances=False, return_indices=True)
    return LabelMap(phantom.grid, phantom.values[tuple(nearest)])


def tissue_at(segmentation: LabelMap, points: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    """Label (n,) uint8 of the voxels at points (n, 3); where that is no soft tissue, `otherwise` (n,)."""
    index = np.rint(segmentation.grid.indices(points)).astype(int)
    shape = np.array(segmentation.grid.shape)
    found = segmentation.values[tuple(np.clip(index, 0, shape - 1).T)]
    soft = np.isin(found, DEFORMABLE) & np.all((index >= 0) & (index < shape), axis=1)
    return np.where(soft, found, otherwise).astype(np.uint8)


def skin_depth(mesh: TetMesh, inside: np.ndarray, grid: Grid) -> np.ndarray:
    """Distance (nz, ny, nx) in mm from each voxel to the skin's outside; inf where no skin is near the grid.

    An outside voxel next to the body is air when the nearest boundary of the mesh is 'skin'; the distance to
    its centre, less half a voxel, is on average the distance to the surface between.
    """
    rim = ndimage.binary_dilation(inside) & ~inside
    outside = grid.points(np.argwhere(rim).astype(float))
    distance = {
        name: cKDTree(mesh.points[faces[:, SUBTRIANGLES]].mean(axis=2).reshape(-1, 3)).query(outside)[0]
        for name, faces in mesh.boundaries.items()
        if len(faces)
    }
    beyond = np.min([d for name, d in distance.items() if name != "skin"], axis=0, initial=np.inf)
    air = np.zeros_like(inside)
    air[rim] = distance["skin"] <= beyond
    if not air.any():
        return np.full(inside.shape, np.inf)
    step = grid.spacing[::-1]
    found: np.ndarray = ndimage.distance_transform_edt(~air, sampling=step) - step.mean() / 2
    return found


def conservation_table(
    mesh: TetMesh,
    measured: np.ndarray,
    segmentation: LabelMap,
    phantom: LabelMap,
    *,
    density_g_cm3: Mapping[Label, float],
) -> pd.DataFrame:
    """What becomes of the tissue inside the phantom's field, from the measured shape to the voxels.

    Columns quantity, tissue, step, before, after, relative_change. Steps of volume_mm3: 'deformation', from
    the measured shape to the deformed mesh (the integral of J); 'voxels', from there to the phantom without
    lesion.
    mass_g: 'all steps', each tissue with its own density.
    """
    body = material_volume(mesh, measured)
    near = ndimage.binary_dilation(phantom.values != Label.AIR)
    in_field = _voxels_at(LabelMap(phantom.grid, near.astype(np.uint8)), body.carry(mesh, mesh.points)) > 0
    tissue = tissue_at(segmentation, body.carry(mesh, measured), mesh.tissue[body.cell])
    rows = []
    for name, labels in GROUPS.items():
        before, between, after = _volumes(body, in_field, tissue, phantom, labels)
        # ASSUME: a tissue whose density is not given, as skin, weighs as much as fat.
        rho = np.array([density_g_cm3.get(label, density_g_cm3[Label.ADIPOSE]) for label in labels])
        rows += [
            ("volume_mm3", name, "deformation", before.sum(), between.sum()),
            ("volume_mm3", name, "voxels", between.sum(), after.sum()),
            ("mass_g", name, "all steps", _mass(rho, before), _mass(rho, after)),
        ]
    table = pd.DataFrame(rows, columns=["quantity", "tissue", "step", "before", "after"])
    table = table[table.before > 0].reset_index(drop=True)
    return table.assign(relative_change=table.after / table.before - 1)


def _volumes(
    body: MaterialVolume,
    in_field: np.ndarray,
    tissue: np.ndarray,
    phantom: LabelMap,
    labels: tuple[Label, ...],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volumes in mm3 of each label: measured, deformed, and as voxels."""
    of = [in_field & (tissue == label) for label in labels]
    voxels = [np.count_nonzero(phantom.values == label) * phantom.grid.voxel_volume for label in labels]
    return (
        np.array([body.dV[m].sum() for m in of]),
        np.array([body.dv[m].sum() for m in of]),
        np.array(voxels),
    )


def _mass(rho: np.ndarray, volume: np.ndarray) -> float:
    """sum rho V, g."""
    return float(rho @ volume) / MM3_PER_CM3


def _voxels_at(labels: LabelMap, points: np.ndarray) -> np.ndarray:
    """Value (n,) of the voxel that holds each point (n, 3), 0 outside the grid."""
    index = np.rint(labels.grid.indices(points)).astype(int)
    shape = np.array(labels.grid.shape)
    inside = np.all((index >= 0) & (index < shape), axis=1)
    return np.where(inside, labels.values[tuple(np.clip(index, 0, shape - 1).T)], 0)
