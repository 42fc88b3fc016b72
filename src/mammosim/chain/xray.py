"""X-ray products of a chain: the pressed breast as voxels, its beam, exposure, dose, scatter, image, slices.

Effects: polychromatic, paddle, scatter, response, and those of chain.image_chain.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.calcifications import Search, cluster_row
from mammosim.chain.graph import Inputs, Product
from mammosim.chain.image_chain import BEFORE, EFFECTS, Taken
from mammosim.chain.mammogram import (
    SENSOR_MM,
    View,
    dose_in,
    mammogram,
    scatter_behind,
    scatter_cells,
    scatter_from,
    xray_phantom,
)
from mammosim.chain.phantom import Lesion, field_box, field_grid, healthy, voxel_breast, with_lesion
from mammosim.chain.tomosynthesis import Arc, Masks, ScatterAt, slices_grid
from mammosim.chain.view import craniocaudal
from mammosim.core.rng import generator, seed_of
from mammosim.core.volume import LabelMap
from mammosim.xray.dose import GlandularDose
from mammosim.xray.exposure import automatic_mas
from mammosim.xray.geometry import Geometry
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.quality import Paddle, in_the_way
from mammosim.xray.reconstruction import sart
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.systems import system_named
from mammosim.xray.tube import tube_spectrum

TUBE = ("anode", "filter", "filter_um", "peak_kv")
GEOMETRY = ("source_to_detector_mm", "support_to_detector_mm", "pixel_mm", "field_mm")
CHAIN = ("detector", "focal_spot_mm", "grid", "structure_percent")


def _xray(*names: str) -> tuple[str, ...]:
    return tuple(f"xray.{name}" for name in names)


@dataclass(frozen=True)
class Voxels:
    """The pressed breast with its lesion, common frame of its image; plates: chain.plates.plate_facts."""

    labels: LabelMap
    plates: Mapping[str, float]


def _phantom(inputs: Inputs) -> Voxels:
    breast: Breast = inputs.subject
    mesh, found, given = inputs["mesh"], inputs["pressed"], inputs.setting("xray.lesion")
    measured = breast.to_reference.inverse()(mesh.points)
    shape = mesh.moved_to(found.points)
    low, high = field_box(
        breast.side,
        midline_mm=0.0,
        chest_wall_mm=found.plates["chest_y_mm"],
        bottom_mm=found.plates["support_z_mm"],
        top_mm=found.plates["paddle_z_mm"],
    )
    grid = field_grid(shape, low, high, voxel_mm=inputs.setting("xray.voxel_mm"))
    skin_mm = inputs.setting("tissues.skin.thickness_mm")
    labels = voxel_breast(shape, measured, breast.labels, grid=grid, skin_mm=skin_mm)
    lesion = Lesion.behind(
        breast.nipple,
        inwards=np.array([0.0, 1.0, 0.0]),
        depth_mm=given["depth_mm"],
        diameter_mm=given["diameter_mm"],
    )
    return Voxels(with_lesion(labels, shape, measured, lesion), found.plates)


def _spectrum(inputs: Inputs) -> Spectrum:
    """The beam that reaches the breast; without `polychromatic` all its photons have their mean energy."""
    anode, filter_, filter_um, kv = (inputs.setting(f"xray.{name}") for name in TUBE)
    paddle = (Paddle(**inputs.setting("xray.paddle")),) if inputs.has("paddle") else ()
    beam = in_the_way(tube_spectrum(anode, filter_, filter_um / 1e3, kv), paddle)
    return beam.rebinned(inputs.setting("xray.energies") if inputs.has("polychromatic") else 1)


def _geometry(inputs: Inputs) -> Geometry:
    voxels: Voxels = inputs["phantom"]
    settings = {name: inputs.setting(f"xray.{name}") for name in GEOMETRY}
    return craniocaudal(voxels.labels, chest_y_mm=voxels.plates["chest_y_mm"], **settings)


def _exposure(inputs: Inputs) -> float:
    """mAs of automatic exposure, without the lesion."""
    geometry, phantom = inputs["geometry"], xray_phantom(healthy(inputs["phantom"].labels))
    return automatic_mas(
        primary(phantom, geometry, inputs["spectrum"]).kerma_mgy,
        path_lengths(phantom, geometry)[..., 1:].sum(axis=-1) > 0,
        target_mgy=inputs.setting("xray.detector_kerma_ugy") / 1e3,
        sensor_pixels=max(round(SENSOR_MM / geometry.detector.pixel_mm), 1),
    )


def _dose(inputs: Inputs) -> GlandularDose:
    """Per mAs."""
    return dose_in(
        inputs["phantom"].labels,
        inputs["geometry"],
        inputs["spectrum"],
        relative_error=inputs.setting("xray.dose_error_percent") / 100,
        seed=seed_of(*inputs.subject.names, "photons"),
    )


def _scatter(inputs: Inputs) -> pd.DataFrame | None:
    """Cells of chain.mammogram.scatter_cells; None where scatter is not simulated."""
    if not inputs.has("scatter"):
        return None
    found = scatter_behind(
        inputs["phantom"].labels,
        inputs["geometry"],
        inputs["spectrum"],
        relative_error=inputs.setting("xray.scatter_error_percent") / 100,
        cell_mm=inputs.setting("xray.scatter_pixel_mm"),
        seed=seed_of(*inputs.subject.names, "scatter"),
    )
    return scatter_cells(found)


def _names(inputs: Inputs) -> tuple[str, ...]:
    return tuple(name for name in (*BEFORE, *EFFECTS) if inputs.has(name))


def _settings(inputs: Inputs) -> dict:
    seed = inputs.subject.names[0]
    return {name: inputs.setting(f"xray.{name}") for name in (*CHAIN, *TUBE)} | {"seed": seed}


def _image(inputs: Inputs) -> dict[str, float]:
    """The row of chain.mammogram, and of chain.calcifications."""
    voxels, geometry, names = inputs["phantom"], inputs["geometry"], inputs.subject.names
    middle = inputs.setting("xray.support_to_detector_mm") + voxels.plates["thickness_mm"] / 2
    cells = inputs["scatter"]
    view = View(
        Taken(geometry, middle, _settings(inputs)),
        inputs["spectrum"],
        inputs.setting("xray.detector_kerma_ugy") / 1e3,
        _names(inputs),
        None if cells is None else scatter_from(cells, geometry),
        inputs.setting("xray.rays_per_pixel"),
    )
    row = mammogram(voxels.labels, view, rng=generator(*names, "quantum noise")).row
    search = Search.drawn(**inputs.setting("xray.calcifications"), rng=generator(names[0], "calcifications"))
    stream = generator(*names, "cluster")
    return row | cluster_row(voxels.labels, view, search, mas=row["mas"], rng=stream)


def _slices(inputs: Inputs) -> dict[str, float]:
    """CNR of the lesion in its slice by SART."""
    voxels, given, names = inputs["phantom"], inputs.setting("xray.tomosynthesis"), inputs.subject.names
    seen = {
        "chest_y_mm": voxels.plates["chest_y_mm"], "settings": _settings(inputs), "effects": _names(inputs)
    }  # fmt: skip
    system = system_named(given["system"])
    scatter: tuple[ScatterAt, ...] = ()
    if inputs.has("scatter"):
        cell_mm = inputs.setting("xray.scatter_pixel_mm")
        coarse = Arc.of(voxels.labels, system, inputs["spectrum"], pixel_mm=cell_mm, **seen)
        error = inputs.setting("xray.scatter_error_percent") / 100
        stream = seed_of(*names, "arc")
        scatter = coarse.scattered(voxels.labels, given["scatter_views"], relative_error=error, seed=stream)
    arc = Arc.of(voxels.labels, system, inputs["spectrum"], pixel_mm=given["pixel_mm"], **seen)
    mas = given["exposure_share"] * inputs["exposure"]
    b = arc.integrals(voxels.labels, mas=mas, scatter=scatter, rng=generator(*names, "views"))
    grid = slices_grid(voxels.labels, voxel_mm=given["pixel_mm"], slice_mm=given["slice_mm"])
    reconstructed = partial(sart, iterations=given["iterations"])
    return Masks.of(voxels.labels, grid).row(reconstructed(b, arc.geometries, grid).image)


IMAGE = (*BEFORE, *EFFECTS)
_CHAIN = _xray(*CHAIN, *TUBE)
_SCATTER = _xray("scatter_error_percent", "scatter_pixel_mm")
PRODUCTS: Mapping[str, Product] = {
    "phantom": Product(
        _phantom,
        ("mesh", "pressed"),
        (*_xray("voxel_mm", "lesion"), "tissues.skin.thickness_mm"),
    ),
    "spectrum": Product(
        _spectrum, reads=_xray(*TUBE, "paddle", "energies"), effects=("polychromatic", "paddle")
    ),
    "geometry": Product(_geometry, ("phantom",), _xray(*GEOMETRY)),
    "exposure": Product(_exposure, ("phantom", "geometry", "spectrum"), _xray("detector_kerma_ugy")),
    "dose": Product(_dose, ("phantom", "geometry", "spectrum"), _xray("dose_error_percent")),
    "scatter": Product(_scatter, ("phantom", "geometry", "spectrum"), _SCATTER, ("scatter",)),
    "image": Product(
        _image,
        ("phantom", "geometry", "spectrum", "scatter"),
        (*_CHAIN, *_xray("support_to_detector_mm", "detector_kerma_ugy", "calcifications", "rays_per_pixel")),
        IMAGE,
    ),
    "slices": Product(
        _slices, ("phantom", "spectrum", "exposure"), (*_CHAIN, *_SCATTER, "xray.tomosynthesis"), IMAGE
    ),
}
