"""One drawn body between the plates: the force that it takes, and its glandular dose."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.chain.mammogram import SENSOR_MM, dose_in, xray_phantom
from mammosim.chain.phantom import field_box, field_grid, voxel_breast
from mammosim.chain.plates import craniocaudal_plates, plate_facts
from mammosim.chain.points import MaterialPoints
from mammosim.chain.view import craniocaudal
from mammosim.core.mesh import TetMesh
from mammosim.core.volume import LabelMap
from mammosim.mechanics.body import Body
from mammosim.mechanics.compression import Compression, compress
from mammosim.mechanics.control import Thickness
from mammosim.xray.exposure import automatic_mas
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.spectrum import Spectrum


@dataclass(frozen=True)
class Measured:
    """A mesh, one nipple (3,) mm, and a segmentation, in whose frame the nodes are `scanned` (n_node, 3)."""

    mesh: TetMesh
    nipple: np.ndarray
    segmentation: LabelMap
    scanned: np.ndarray


@dataclass(frozen=True)
class Pressed:
    """A compression, its stress-free mesh, and where its plates stand, see chain.plates.plate_facts."""

    mesh: TetMesh
    found: Compression
    facts: Mapping[str, float]

    @property
    def force_n(self) -> float:
        """Of the upper plate."""
        return float(self.found.path.force_n.iloc[-1])


def pressed(
    measured: Measured,
    body: Body,
    rest: np.ndarray,
    *,
    thickness_mm: float,
    plate_mm: Mapping[str, float],
    chest_gap_mm: float,
) -> Pressed:
    """A body with the stress-free shape rest (n_node, 3) between plates around its nipple, without gravity.

    Raises EquilibriumError when no verified equilibrium was reached.
    """
    mesh = measured.mesh.moved_to(rest)
    nipple = MaterialPoints.on(measured.mesh, measured.nipple[None]).carry(rest)[0]
    plates = craniocaudal_plates(mesh, nipple, plate_mm=plate_mm, chest_gap_mm=chest_gap_mm)
    found = compress(mesh, body.effects(mesh), plates=plates, control=Thickness(thickness_mm))
    return Pressed(mesh, found, plate_facts(plates, thickness_mm))


def glandular_dose(
    measured: Measured,
    between: Pressed,
    spectrum: Spectrum,
    *,
    side: str,
    settings: Mapping[str, Any],
    seed: int,
) -> dict[str, float]:
    """agd_mgy and its standard error agd_se_mgy of a breast between plates, at automatic exposure.

    settings: voxel_mm, skin_mm, geometry of chain.view.craniocaudal, dose_error_percent,
    detector_kerma_ugy.
    """
    labels = _voxels(measured, between, side, settings)
    geometry = craniocaudal(labels, chest_y_mm=between.facts["chest_y_mm"], **settings["geometry"])
    dose = dose_in(labels, geometry, spectrum, relative_error=settings["dose_error_percent"] / 100, seed=seed)
    phantom, pixel = xray_phantom(labels), geometry.detector.pixel_mm
    mas = automatic_mas(
        primary(phantom, geometry, spectrum).kerma_mgy,
        path_lengths(phantom, geometry)[..., 1:].sum(axis=-1) > 0,
        target_mgy=settings["detector_kerma_ugy"] / 1e3,
        sensor_pixels=max(round(SENSOR_MM / pixel), 1),
    )
    return {"agd_mgy": dose.mgy_per_mas * mas, "agd_se_mgy": dose.standard_error_mgy_per_mas * mas}


def _voxels(measured: Measured, between: Pressed, side: str, settings: Mapping[str, Any]) -> LabelMap:
    """The breast between the plates as voxels, without lesion."""
    mesh, facts = between.mesh.moved_to(between.found.points), between.facts
    low, high = field_box(
        side,
        midline_mm=0.0,
        chest_wall_mm=facts["chest_y_mm"],
        bottom_mm=facts["support_z_mm"],
        top_mm=facts["paddle_z_mm"],
    )
    grid = field_grid(mesh, low, high, voxel_mm=settings["voxel_mm"])
    return voxel_breast(mesh, measured.scanned, measured.segmentation, grid=grid, skin_mm=settings["skin_mm"])
