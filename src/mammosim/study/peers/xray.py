"""X-ray tasks for several programs: what each is given, and what is made of what it found.

One view, the dose of AAPM report 195 case 3, that of one of its regions, its scatter image, and slices.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from scipy.ndimage import binary_erosion

from mammosim.core.errors import ConfigurationError
from mammosim.io.tabulated import tabulated
from mammosim.study.peers.xray_bodies import beam, body, geometry_at, grid_of, scene_facts
from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.report195 import (
    TISSUE,
    beam_of_report,
    breast_of_report,
    geometry_of_report,
    regions_of_report,
)

Arrays = dict[str, np.ndarray]
COARSER = 8  # times, of what warms a program up
SMALL_REPORT_MM, SMALL_ERROR = 2.0, 0.1
THROUGH = 0.999  # share of the straight way through all slices, of rays that cross their top and bottom
FEWEST_RUNS = 3  # whose scatter says how well their mean is known


class Task(Protocol):
    """One problem, what is given to a program, and what is made of its answer."""

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """Arrays, and facts in plain values."""
        ...

    def small(self) -> "Task":
        """The same, coarse, to compile and load by."""
        ...

    def amounts(self, found: Mapping[str, Any]) -> dict[str, Any]:
        """Columns of the table but for times: value, standard_error, reference, error."""
        ...


def columns(error_is: str, **amounts: Any) -> dict[str, Any]:
    """All columns, nan where a task has none."""
    nothing = dict.fromkeys(("value", "standard_error", "reference", "error"), np.nan)
    return nothing | amounts | {"error_is": error_is}


@dataclass(frozen=True)
class View:
    """One polychromatic image of a body of voxels (nz, ny, nx) on pixels (nv, nu).

    error: against the mean of 3 x 3 exact rays per pixel, root mean square, of rays through all slices; of
    slabs against the closed form, the largest.
    """

    body: str
    voxels: tuple[int, int, int]
    voxel_mm: float
    pixels: tuple[int, int]
    pixel_mm: float
    energies: int

    def scene(self) -> ExposureSetup:
        """Body, geometry and beam."""
        phantom = body(self.body, grid_of(self.voxels, self.voxel_mm))
        return ExposureSetup(phantom, geometry_at(0.0, self.pixels, self.pixel_mm), beam(self.energies))

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """index (nz, ny, nx); mu (n_material, n_energy) 1/mm; weights (n_energy,) keV/mm2 per mAs at 1 mm."""
        scene = self.scene()
        E, fluence = scene.spectrum.energies_kev, scene.spectrum.fluence
        weights = fluence * E * scene.spectrum.distance_mm**2
        mu = scene.attenuations()[..., 0].T
        return {"index": scene.phantom.index, "mu": mu, "weights": weights}, scene_facts(scene)

    def small(self) -> "View":
        """Coarser voxels and pixels."""
        return replace(self, **_coarser(self.voxels, self.voxel_mm, self.pixels, self.pixel_mm))

    def amounts(self, found: Mapping[str, Any]) -> dict[str, Any]:
        """found: image (nv, nu), keV/mm2 per mAs."""
        scene = self.scene()
        lengths = path_lengths(scene.phantom, scene.geometry)
        through = _through(scene.phantom, scene.geometry, lengths)
        if self.body == "slabs":
            found_over = found["image"] / self._of_slabs(scene)
            return columns("largest, of itself", error=float(np.abs(found_over[through] - 1).max()))
        exact = primary(scene.phantom, scene.geometry, scene.spectrum, supersampling=3).signal
        off = (found["image"] / exact - 1)[through]
        return columns("root mean square, of itself", error=float(np.sqrt(np.mean(off**2))))

    def _of_slabs(self, scene: ExposureSetup) -> np.ndarray:
        """The image (nv, nu) behind two wide slabs, each as thick as half of the slices."""
        arrays, _ = self.problem()
        r, h = _ways(scene.geometry), scene.geometry.source_height_mm
        nz = self.voxels[0]
        thickness = self.voxel_mm * np.array([nz // 2, nz - nz // 2])
        air = h - thickness.sum()
        per_height = arrays["mu"].T @ np.array([air, *thickness])  # optical depth on the straight way
        return np.exp(-per_height * (r / h)[..., None]) @ arrays["weights"] * h / r**3


@dataclass(frozen=True)
class Dose:
    """Energy in the tissue of the report's breast, eV per photon; relative_error: as well as asked."""

    beam: str
    voxel_mm: float
    relative_error: float

    def scene(self) -> ExposureSetup:
        """The report's, at 0 degrees."""
        return ExposureSetup(breast_of_report(self.voxel_mm), geometry_of_report(), beam_of_report(self.beam))

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """index (nz, ny, nx), and which material is the tissue."""
        scene = self.scene()
        facts = scene_facts(scene) | {"tissue": TISSUE, "relative_error": self.relative_error}
        return {"index": scene.phantom.index}, facts

    def small(self) -> "Dose":
        """Coarse voxels, and a few photons."""
        return replace(self, voxel_mm=SMALL_REPORT_MM, relative_error=SMALL_ERROR)

    def amounts(self, found: Mapping[str, Any]) -> dict[str, Any]:
        """found: value and standard_error [eV], one or several runs of their own streams."""
        return _of_report(self.beam, "tissue", found)


@dataclass(frozen=True)
class Region(Dose):
    """Energy in one of the report's regions of 20 x 20 x 10 mm, 1 to 7."""

    region: int

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """And the box: lower and upper corner, mm."""
        arrays, facts = super().problem()
        return arrays, facts | {"box_mm": regions_of_report()[self.region - 1].tolist()}

    def amounts(self, found: Mapping[str, Any]) -> dict[str, Any]:
        """found: as of Dose."""
        return _of_report(self.beam, f"region {self.region}", found)


@dataclass(frozen=True)
class Scatter(Dose):
    """Scatter per cell behind the report's breast; value: the sum over the cells asked for, eV per photon."""

    cell_mm: float

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """asked (nv, nu) bool: cells behind at least half of the longest way through tissue."""
        arrays, facts = super().problem()
        scene = self.scene()
        detector = scene.geometry.detector.binned(self.cell_mm)
        way = path_lengths(scene.phantom, Geometry(scene.geometry.source, detector))[..., TISSUE]
        return arrays | {"asked": way > way.max() / 2}, facts | {"cell_mm": self.cell_mm}

    def amounts(self, found: Mapping[str, Any]) -> dict[str, Any]:
        """found: value [eV], of one or several runs, whose scatter says how well it is known."""
        values = np.atleast_1d(found["value"])
        spread = float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) >= FEWEST_RUNS else np.nan
        return columns("", value=float(values.mean()), standard_error=spread)


@dataclass(frozen=True)
class Slices:
    """Iterations of SART from views over an arc; error: root mean square in the body, 1/mm."""

    voxels: tuple[int, int, int]
    voxel_mm: float
    pixels: tuple[int, int]
    pixel_mm: float
    views: int
    arc_deg: float
    energy_kev: float
    iterations: int

    def geometries(self) -> list[Geometry]:
        """One per angle."""
        angles = np.linspace(-self.arc_deg / 2, self.arc_deg / 2, self.views)
        return [geometry_at(angle, self.pixels, self.pixel_mm) for angle in angles]

    def truth(self) -> tuple[Phantom, np.ndarray]:
        """The breast, and by how much each material attenuates more than air, 1/mm."""
        phantom = body("breast", grid_of(self.voxels, self.voxel_mm))
        mu = [linear_attenuation(m, np.array([self.energy_kev]))[0] for m in phantom.materials]
        return phantom, np.array(mu) - mu[0]

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """integrals (n_view, nv, nu), sources (n_view, 3) mm; the grid of the slices."""
        phantom, mu = self.truth()
        views = self.geometries()
        integrals = np.stack([(path_lengths(phantom, view) @ mu).astype(np.float32) for view in views])
        sources = np.array([view.source for view in views])
        scene = ExposureSetup(phantom, views[0], beam(1))
        facts = scene_facts(scene) | {"shape": list(self.voxels), "iterations": self.iterations}
        return {"integrals": integrals, "sources": sources}, facts

    def small(self) -> "Slices":
        """Coarser voxels and pixels, three views."""
        coarser = _coarser(self.voxels, self.voxel_mm, self.pixels, self.pixel_mm)
        return replace(self, **coarser, views=3)

    def amounts(self, found: Mapping[str, Any]) -> dict[str, Any]:
        """found: slices (nz, ny, nx), 1/mm."""
        phantom, mu = self.truth()
        off = (found["slices"] - mu[phantom.index])[phantom.index > 0]
        return columns("root mean square in the body, 1/mm", error=float(np.sqrt(np.mean(off**2))))


KINDS: dict[str, type] = {"view": View, "dose": Dose, "region": Region, "scatter": Scatter, "slices": Slices}


def task_of(kind: str, values: Mapping[str, Any]) -> Task:
    """A task as configured. Raises ConfigurationError for an unknown kind."""
    if kind not in KINDS:
        raise ConfigurationError(f"unknown task {kind!r}; choose one of: {', '.join(KINDS)}")
    lists = {name: tuple(value) if isinstance(value, list) else value for name, value in values.items()}
    return KINDS[kind](**lists)


def _of_report(beam_name: str, quantity: str, found: Mapping[str, Any]) -> dict[str, Any]:
    """The mean of the runs beside the report's mean of codes, both eV per photon."""
    values, errors = np.atleast_1d(found["value"]), np.atleast_1d(found["standard_error"])
    table = tabulated("report195_case3").query("beam == @beam_name and quantity == @quantity")
    reference, value = float(table["report_ev"].iloc[0]), float(values.mean())
    return columns(
        "of the report's mean",
        value=value,
        standard_error=float(np.sqrt(np.sum(errors**2)) / len(errors)),
        reference=reference,
        error=abs(value / reference - 1),
    )


def _ways(geometry: Geometry) -> np.ndarray:
    """Distance (nv, nu) of the pixels' centres from the source, mm."""
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    ends = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    return np.linalg.norm(ends - geometry.source, axis=-1)


def _through(phantom: Phantom, geometry: Geometry, lengths: np.ndarray) -> np.ndarray:
    """(nv, nu) bool: pixels all of whose rays cross all slices inside the body, as their lengths
    (nv, nu, n_material) and those of the pixels around them say."""
    thickness = phantom.grid.spacing[2] * phantom.grid.shape[0]
    whole = thickness * _ways(geometry) / geometry.source_height_mm
    return binary_erosion(lengths[..., 1:].sum(axis=-1) > THROUGH * whole)


def _coarser(
    voxels: tuple[int, int, int], voxel_mm: float, pixels: tuple[int, int], pixel_mm: float
) -> dict[str, Any]:
    """The same lengths in COARSER times fewer voxels and pixels."""
    return {
        "voxels": tuple(max(n // COARSER, 2) for n in voxels),
        "voxel_mm": voxel_mm * COARSER,
        "pixels": tuple(max(n // COARSER, 2) for n in pixels),
        "pixel_mm": pixel_mm * COARSER,
    }
