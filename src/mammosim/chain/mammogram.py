"""From the compressed breast as voxels to its dose, its X-ray image, and how well a lesion shows in it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd
from scipy import ndimage

from mammosim.chain.image_chain import Acquisition, ImageChain
from mammosim.chain.phantom import healthy
from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.volume import LabelMap
from mammosim.xray.attenuation import Material, material, mixture
from mammosim.xray.blocks import Limits
from mammosim.xray.detector import Exposure, Scatter, expose, on_pixels
from mammosim.xray.dose import GlandularDose, air_kerma_at, mean_glandular_dose
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Geometry
from mammosim.xray.observer import Contrast, cnr
from mammosim.xray.phantom import Phantom, phantom_of_labels
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tally_request import EnergyIn, ScatterImage
from mammosim.xray.tally_result import ScatterResult

# ASSUME: a lesion attenuates as gland of density 1.06 g/cm3.
LESION_DENSITY_G_CM3 = 1.06
# Background around the lesion's shadow, in mm from its edge.
RING_MM = (2.0, 8.0)
SENSOR_MM = 10.0


@dataclass(frozen=True)
class View:
    """How an image is taken: acquisition, spectrum, names of its steps (chain.image_chain).

    scatter: as it reaches the detector's pixels; None where it is not simulated. rays: per pixel and axis.
    """

    acquisition: Acquisition
    spectrum: Spectrum
    steps: tuple[str, ...]
    scatter: Scatter | None = None
    rays: int = 1

    @property
    def geometry(self) -> Geometry:
        """Source and detector."""
        return self.acquisition.geometry

    @cached_property
    def chain(self) -> ImageChain:
        """The steps of its image."""
        return ImageChain.named(self.steps, self.acquisition)

    @cached_property
    def scatter_seen(self) -> Scatter | None:
        """What scatter leaves in the detector."""
        response = self.chain.response
        return self.scatter if self.scatter is None or response is None else self.scatter.left_in(response)

    def on(self, patch: Geometry) -> "View":
        """The same on a small part of the detector, over which scatter does not change, with other pixels."""
        acquisition, scatter = replace(self.acquisition, geometry=patch), self.scatter
        if scatter is not None:
            d = self.geometry.detector
            s, t = d.along(patch.detector.middle)
            row, column = (int(np.clip(x // d.pixel_mm, 0, n - 1)) for x, n in zip((t, s), d.shape))
            parts = (scatter.signal, scatter.signal_squared)
            scatter = Scatter(*(np.full(patch.detector.shape, part[row, column]) for part in parts))
        return replace(self, acquisition=acquisition, scatter=scatter)


@dataclass(frozen=True)
class Mammogram:
    """The exposure with lesion and noise; lesion and ring (nv, nu) bool; one row of what was measured."""

    exposure: Exposure
    lesion: np.ndarray
    ring: np.ndarray
    pixel_mm: float
    row: dict[str, float]


def tissue_materials() -> Mapping[Label, Material]:
    """What the tissues of a breast consist of, for X-rays."""
    # ASSUME: muscle attenuates as ICRU soft tissue.
    gland = material("glandular")
    return {
        Label.AIR: material("air"),
        Label.ADIPOSE: material("adipose"),
        Label.GLANDULAR: gland,
        Label.SKIN: material("skin"),
        Label.MUSCLE: material("soft_tissue"),
        Label.LESION: mixture("lesion", ((gland, 1.0),), density_g_cm3=LESION_DENSITY_G_CM3),
    }


def xray_phantom(labels: LabelMap) -> Phantom:
    """The compressed breast as materials; index is the label."""
    return phantom_of_labels(labels, tissue_materials())


def dose_in(
    labels: LabelMap, geometry: Geometry, spectrum: Spectrum, *, relative_error: float, seed: int
) -> GlandularDose:
    """Glandular dose of this breast by photon Monte Carlo.

    labels (nz, ny, nx): the pressed breast; geometry: source and detector, mm; spectrum: in vacuum, per mAs;
    relative_error: the standard error to reach, relative; seed: of the random streams.
    Returns mGy per mAs with its standard error, and the incident air kerma.
    Raises XrayError where no voxel is gland, or the error would take too many photons.
    """
    # ASSUME: the support is not in the beam; the paddle attenuates it, but scatters nothing into the breast.
    phantom = xray_phantom(labels)
    setup = ExposureSetup(phantom, geometry, spectrum)
    energies = EnergyIn(Label.GLANDULAR, relative_error).result(setup, seed=seed, limits=Limits())
    air = phantom.materials[Label.AIR]
    kerma = air_kerma_at(_entrance(labels, geometry), geometry, spectrum, air=air)
    return mean_glandular_dose(energies, phantom, index=Label.GLANDULAR, incident_kerma_mgy_per_mas=kerma)


def scatter_behind(
    labels: LabelMap,
    geometry: Geometry,
    spectrum: Spectrum,
    *,
    relative_error: float,
    cell_mm: float,
    seed: int,
) -> ScatterResult:
    """Scatter on cells of the detector, cell_mm wide, to the asked error per cell behind the breast."""
    # ASSUME: there is fat all over a breast: cells with half of the longest way through it are behind it.
    setup = ExposureSetup(xray_phantom(labels), geometry, spectrum)
    return ScatterImage(Label.ADIPOSE, relative_error, cell_mm).result(setup, seed=seed, limits=Limits())


def scatter_cells(found: ScatterResult) -> pd.DataFrame:
    """A row per cell of the detector: row, column, cell_mm, and per mAs scatter, scatter_squared with *_se.

    In keV/mm2, and of the square in keV2/mm2.
    """
    row, column = np.indices(found.detector.shape)
    cells = {"row": row, "column": column, "cell_mm": np.full(row.shape, found.detector.pixel_mm)}
    for name in ("scatter", "scatter_squared"):
        per_mas = found.per_mas(getattr(found, name))
        cells |= {name: per_mas.value, f"{name}_se": per_mas.error}
    return pd.DataFrame({name: values.ravel() for name, values in cells.items()})


def scatter_from(cells: pd.DataFrame, geometry: Geometry) -> Scatter:
    """The scatter of scatter_cells on the pixels of a geometry with the same detector area.

    Raises XrayError when the cells cover another area.
    """
    shape = (int(cells.row.max()) + 1, int(cells.column.max()) + 1)
    cell_mm, pixels = float(cells.cell_mm.iloc[0]), geometry.detector
    size = (shape[1] * cell_mm, shape[0] * cell_mm)
    if not np.allclose(size, pixels.size_mm, atol=1e-3):
        raise XrayError(
            f"scatter cells cover {size} mm, the detector {pixels.size_mm} mm; use the same field"
        )
    ordered = cells.sort_values(["row", "column"])
    tallies = (ordered[name].to_numpy().reshape(shape) for name in ("scatter", "scatter_squared"))
    coarse = pixels.binned(cell_mm)
    return Scatter(*(on_pixels(tally, coarse, pixels) for tally in tallies))


def shot_of(labels: LabelMap, view: View, *, mas: float, rng: np.random.Generator) -> Mammogram:
    """One exposure of a breast with a lesion.

    Raises XrayError when there is no lesion, or its shadow misses the detector.
    """
    phantom, pixel = xray_phantom(labels), view.geometry.detector.pixel_mm
    lengths = path_lengths(phantom, view.geometry)
    lesion, ring = _lesion_masks(lengths, pixel)
    with_it, without = (
        primary(p, view.geometry, view.spectrum, response=view.chain.response, supersampling=view.rays)
        for p in (phantom, xray_phantom(healthy(labels)))
    )
    scatter = view.scatter_seen
    exposure, plain = (
        expose(p, scatter, mas=mas, pixel_mm=pixel, rng=rng, steps=view.chain.steps)
        for p in (with_it, without)
    )
    row = _row(cnr(exposure.image, lesion, ring), exposure, plain, lesion)
    row |= {
        "scatter_to_primary": float((scatter.signal / without.signal)[lesion].mean()) if scatter else 0.0,
        "thickness_at_lesion_mm": float(lengths[lesion, 1:].sum(-1).mean()),
    }
    return Mammogram(exposure, lesion, ring, pixel, row)


def _row(measured: Contrast, exposure: Exposure, plain: Exposure, lesion: np.ndarray) -> dict[str, float]:
    """CNR as measured, and its limit: the lesion's own contrast over the quantum noise of a pixel."""
    difference = (plain.mean - exposure.mean)[lesion].mean()
    return {
        "mas": exposure.mas,
        "cnr": measured.cnr,
        "cnr_se": measured.standard_error,
        "contrast_percent": float(100 * difference / plain.mean[lesion].mean()),
        "cnr_quantum": float(difference / plain.noise[lesion].mean()),
        "snr": float((plain.mean / plain.noise)[lesion].mean()),
        "lesion_pixels": int(lesion.sum()),
    }


def _lesion_masks(lengths: np.ndarray, pixel_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """Pixels behind at least half of the lesion's thickness, and a ring of breast around its shadow."""
    through = lengths[..., Label.LESION]
    if not through.max() > 0:
        raise XrayError("no ray meets a lesion; insert one that lies in the X-ray field")
    distance = ndimage.distance_transform_edt(through == 0) * pixel_mm
    breast = lengths[..., 1:].sum(axis=-1) > 0
    return through >= through.max() / 2, (distance >= RING_MM[0]) & (distance <= RING_MM[1]) & breast


def _entrance(labels: LabelMap, geometry: Geometry) -> np.ndarray:
    """The point (3,) where the beam enters the upper plate's side above the middle of the breast."""
    inside = labels.grid.points(np.argwhere(labels.values != Label.AIR).astype(float))
    top = inside[:, 2].max() + labels.grid.spacing[2] / 2
    return np.array([inside[:, 0].mean(), inside[:, 1].mean(), top])
