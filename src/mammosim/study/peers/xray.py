"""X-ray tasks for several programs: what each is given, and what is made of what it found.

One view, the dose of AAPM report 195 case 3, that of one of its regions, its scatter image, and slices.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, Protocol

import numpy as np

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Count, Limits, Settings, read
from mammosim.io.tabulated import tabulated
from mammosim.study.peers.xray_bodies import (
    beam,
    body,
    coarsened,
    geometry_at,
    grid_of,
    setup_facts,
    through,
    ways,
)
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
NOTHING: Any = (np.nan,)
SMALL_REPORT_MM, SMALL_ERROR = 2.0, 0.1  # of what warms a program up
Length = Annotated[float, Limits(above=0, at_most=400)]  # a coarse task has longer ones
Relative = Annotated[float, Limits(above=0, below=1, advice="0.01 is one percent")]
FEWEST_RUNS = 3  # whose scatter says how well their mean is known


@dataclass(frozen=True)
class Answer:
    """What a program found: image or slices, or of each run (n_run,) value and standard_error [eV]; its cost.

    reached: the relative standard error. What a program did not say is nan or None.
    """

    outcome: str = "converged"
    image: np.ndarray | None = None
    slices: np.ndarray | None = None
    value: np.ndarray = NOTHING
    standard_error: np.ndarray = NOTHING
    cpu_s: np.ndarray = NOTHING
    reached: np.ndarray = NOTHING
    histories: np.ndarray = NOTHING
    setup_s: float = np.nan
    memory_mb: float = np.nan
    memory_before_mb: float = np.nan

    def __post_init__(self) -> None:
        for name in ("value", "standard_error", "cpu_s", "reached", "histories"):
            object.__setattr__(self, name, np.atleast_1d(getattr(self, name)))

    def times(self, relative_error: float | None) -> dict[str, Any]:
        """Median, least and most processor-seconds of the runs, and what follows from them.

        seconds: the median time to relative_error, which falls as its square; histories_per_s: the median.
        """
        cpu_s = self.cpu_s
        to_reached = cpu_s if relative_error is None else cpu_s * (self.reached / relative_error) ** 2
        return {
            "seconds": float(np.median(to_reached)),
            "cpu_s": float(np.median(cpu_s)),
            "cpu_least_s": float(cpu_s.min()),
            "cpu_most_s": float(cpu_s.max()),
            "runs": int(np.isfinite(cpu_s).sum()),
            "histories": float(np.median(self.histories)),
            "histories_per_s": float(np.median(self.histories / cpu_s)),
            "reached": float(np.median(self.reached)),
        }


class Task(Protocol):
    """One problem, what is given to a program, and what is made of its answer."""

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """Arrays, and facts in plain values."""
        ...

    def small(self) -> "Task":
        """The same, coarse, to compile and load by."""
        ...

    def amounts(self, found: Answer) -> dict[str, Any]:
        """Columns of the table but for times: value, standard_error, reference, error."""
        ...


def columns(error_is: str, **amounts: Any) -> dict[str, Any]:
    """All columns, nan where a task has none."""
    nothing = dict.fromkeys(("value", "standard_error", "reference", "error"), np.nan)
    return nothing | amounts | {"error_is": error_is}


@dataclass(frozen=True)
class View(Settings):
    """One polychromatic image of a body of voxels (nz, ny, nx) on pixels (nv, nu).

    error: against the mean of 3 x 3 exact rays per pixel, root mean square, of rays through all slices; of
    slabs against the closed form, the largest.
    """

    body: Literal["breast", "slabs"]
    voxels: tuple[Count, Count, Count]
    voxel_mm: Length
    pixels: tuple[Count, Count]
    pixel_mm: Length
    energies: Count

    def setup(self) -> ExposureSetup:
        """Body, geometry and beam."""
        phantom = body(self.body, grid_of(self.voxels, self.voxel_mm))
        return ExposureSetup(phantom, geometry_at(0.0, self.pixels, self.pixel_mm), beam(self.energies))

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """index (nz, ny, nx); mu (n_material, n_energy) 1/mm; weights (n_energy,) keV/mm2 per mAs at 1 mm."""
        setup = self.setup()
        E, fluence = setup.spectrum.energies_kev, setup.spectrum.fluence
        weights = fluence * E * setup.spectrum.distance_mm**2
        mu = setup.attenuations()[..., 0].T
        return {"index": setup.phantom.index, "mu": mu, "weights": weights}, setup_facts(setup)

    def small(self) -> "View":
        """Coarser voxels and pixels."""
        return replace(self, **coarsened(self.voxels, self.voxel_mm, self.pixels, self.pixel_mm))

    def amounts(self, found: Answer) -> dict[str, Any]:
        """found: image (nv, nu), keV/mm2 per mAs."""
        setup = self.setup()
        lengths = path_lengths(setup.phantom, setup.geometry)
        inside = through(setup.phantom, setup.geometry, lengths)
        if self.body == "slabs":
            off = (found.image / self._of_slabs(setup) - 1)[inside]
            return columns("largest, of itself", error=float(np.abs(off).max()))
        exact = primary(setup.phantom, setup.geometry, setup.spectrum, supersampling=3).signal
        off = (found.image / exact - 1)[inside]
        return columns("root mean square, of itself", error=float(np.sqrt(np.mean(off**2))))

    def _of_slabs(self, setup: ExposureSetup) -> np.ndarray:
        """The image (nv, nu) behind two wide slabs, each as thick as half of the slices."""
        arrays, _ = self.problem()
        r, h = ways(setup.geometry), setup.geometry.source_height_mm
        nz = self.voxels[0]
        thickness = self.voxel_mm * np.array([nz // 2, nz - nz // 2])
        air = h - thickness.sum()
        per_height = arrays["mu"].T @ np.array([air, *thickness])  # optical depth on the straight way
        return np.exp(-per_height * (r / h)[..., None]) @ arrays["weights"] * h / r**3


@dataclass(frozen=True)
class Dose(Settings):
    """Energy in the tissue of the report's breast, eV per photon; relative_error: how well."""

    beam: Literal["16.8 keV", "Mo/Mo 30 kVp"]
    voxel_mm: Length
    relative_error: Relative

    def setup(self) -> ExposureSetup:
        """The report's, at 0 degrees."""
        return ExposureSetup(breast_of_report(self.voxel_mm), geometry_of_report(), beam_of_report(self.beam))

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """index (nz, ny, nx), and which material is the tissue."""
        setup = self.setup()
        facts = setup_facts(setup) | {"tissue": TISSUE, "relative_error": self.relative_error}
        return {"index": setup.phantom.index}, facts

    def small(self) -> "Dose":
        """Coarse voxels, and a few photons."""
        return replace(self, voxel_mm=SMALL_REPORT_MM, relative_error=SMALL_ERROR)

    def amounts(self, found: Answer) -> dict[str, Any]:
        """found: value and standard_error [eV], one or several runs of their own random streams."""
        return _of_report(self.beam, "tissue", found)


@dataclass(frozen=True)
class Region(Dose):
    """Energy in one of the report's regions of 20 x 20 x 10 mm, 1 to 7."""

    region: Annotated[int, Limits(at_least=1, at_most=7)]

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """And the box: lower and upper corner, mm."""
        arrays, facts = super().problem()
        return arrays, facts | {"box_mm": regions_of_report()[self.region - 1].tolist()}

    def amounts(self, found: Answer) -> dict[str, Any]:
        """found: as of Dose."""
        return _of_report(self.beam, f"region {self.region}", found)


@dataclass(frozen=True)
class Scatter(Dose):
    """Scatter per cell behind the report's breast; value: the sum over these cells, eV per photon."""

    cell_mm: Length

    def problem(self) -> tuple[Arrays, dict[str, Any]]:
        """cells (nv, nu) bool: those behind at least half of the longest way through tissue."""
        arrays, facts = super().problem()
        setup = self.setup()
        detector = setup.geometry.detector.binned(self.cell_mm)
        way = path_lengths(setup.phantom, Geometry(setup.geometry.source, detector))[..., TISSUE]
        return arrays | {"cells": way > way.max() / 2}, facts | {"cell_mm": self.cell_mm}

    def amounts(self, found: Answer) -> dict[str, Any]:
        """found: value [eV], of one or several runs, whose scatter says how well it is known."""
        values, n = found.value, len(found.value)
        error = float(values.std(ddof=1) / np.sqrt(n)) if n >= FEWEST_RUNS else np.nan
        return columns("", value=float(values.mean()), standard_error=error)


@dataclass(frozen=True)
class Slices(Settings):
    """Iterations of SART from views over an arc; error: root mean square in the body, 1/mm."""

    voxels: tuple[Count, Count, Count]
    voxel_mm: Length
    pixels: tuple[Count, Count]
    pixel_mm: Length
    views: Count
    arc_deg: Annotated[float, Limits(above=0, at_most=60)]
    energy_kev: Annotated[float, Limits(at_least=5, at_most=40)]
    iterations: Count

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
        setup = ExposureSetup(phantom, views[0], beam(1))
        facts = setup_facts(setup) | {"shape": list(self.voxels), "iterations": self.iterations}
        return {"integrals": integrals, "sources": sources}, facts

    def small(self) -> "Slices":
        """Coarser voxels and pixels, three views."""
        return replace(self, **coarsened(self.voxels, self.voxel_mm, self.pixels, self.pixel_mm), views=3)

    def amounts(self, found: Answer) -> dict[str, Any]:
        """found: slices (nz, ny, nx), 1/mm."""
        phantom, mu = self.truth()
        off = (found.slices - mu[phantom.index])[phantom.index > 0]
        return columns("root mean square in the body, 1/mm", error=float(np.sqrt(np.mean(off**2))))


KINDS: dict[str, type] = {"view": View, "dose": Dose, "region": Region, "scatter": Scatter, "slices": Slices}


def task_of(kind: str, values: Mapping[str, Any]) -> Task:
    """A task as configured. Raises ConfigurationError for an unknown kind, key or value."""
    if kind not in KINDS:
        raise ConfigurationError(f"unknown task {kind!r}; choose one of: {', '.join(KINDS)}")
    return read(KINDS[kind], values, "problem")


def row_of(task: Task, found: Answer, relative_error: float | None) -> dict[str, Any]:
    """The row of what a program found, all nan but its outcome if it found nothing."""
    machine = {"setup_s": found.setup_s, "memory_mb": found.memory_mb}
    amounts = task.amounts(found) if found.outcome == "converged" else columns("")
    return found.times(relative_error) | machine | amounts | {"outcome": found.outcome}


def _of_report(beam_name: str, quantity: str, found: Answer) -> dict[str, Any]:
    """The mean of the runs beside the report's mean of codes, both eV per photon."""
    values, errors = found.value, found.standard_error
    table = tabulated("report195_case3").query("beam == @beam_name and quantity == @quantity")
    reference, value = float(table["report_ev"].iloc[0]), float(values.mean())
    return columns(
        "of the report's mean",
        value=value,
        standard_error=float(np.sqrt(np.sum(errors**2)) / len(errors)),
        reference=reference,
        error=abs(value / reference - 1),
    )
