"""The mammogram and the slices of the pressed breast, and how well lesion and calcifications show in them.

Its effects are scatter, response, and the steps of chain.image_chain.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np
import pandas as pd

from mammosim.chain.beam import TOMOSYNTHESIS, require_held
from mammosim.chain.calcifications import Search, SearchSettings, cluster_row
from mammosim.chain.graph import Inputs
from mammosim.chain.image_chain import BEFORE, STEPS, Acquisition, Equipment, Tube
from mammosim.chain.mammogram import Mammogram, View, scatter_from, shot_of
from mammosim.chain.photons import ExposedDose
from mammosim.chain.tomosynthesis import (
    Arc,
    Masks,
    Reconstruction,
    ScanSettings,
    ScatterAt,
    lesion_alone,
    slices_grid,
)
from mammosim.core.rng import generator, seed_of
from mammosim.core.settings import annotations, looked_up, read
from mammosim.core.volume import Grid, Image
from mammosim.io.images import write_image
from mammosim.io.tables import read_table, write_table
from mammosim.xray.reconstruction import filtered_backprojection, sart
from mammosim.xray.systems import system_named

PERCENT = 100.0


@dataclass(frozen=True)
class Seen:
    """A row of what was measured in a mammogram; shot: the image itself, None where read from a file."""

    row: Mapping[str, float]
    shot: Mammogram | None


def mammogram(inputs: Inputs) -> Seen:
    """The mammogram: row of chain.mammogram and chain.calcifications."""
    labels, geometry, streams = inputs["phantom"], inputs["geometry"], inputs.subject.streams
    middle = inputs.setting("xray.support_to_detector_mm") + inputs["pressed"].plates["thickness_mm"] / 2
    view = View(
        Acquisition(geometry, middle, _equipment(inputs), streams[0]),
        inputs["spectrum"],
        _names(inputs),
        scatter_from(inputs["scatter"], geometry) if inputs.has("scatter") else None,
        inputs.setting("xray.rays_per_pixel"),
    )
    mas = inputs["exposure"]
    shot = shot_of(labels, view, mas=mas, rng=generator(*streams, "quantum noise"))
    given = read(SearchSettings, inputs.setting("xray.calcifications"), "xray.calcifications")
    search = Search.sampled(given, rng=generator(streams[0], "calcifications"))
    cluster = cluster_row(labels, view, search, mas=mas, rng=generator(*streams, "cluster"))
    return Seen(shot.row | cluster, shot)


def save_mammogram(seen: Seen, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The row, and three layers: image, pixels of the lesion, and pixels around it."""
    write_table(pd.DataFrame([{**job, **seen.row}]), files["row"])
    if seen.shot is not None:
        shot = seen.shot
        layers = np.stack([shot.exposure.image, shot.lesion, shot.ring]).astype(np.float32)
        spacing = np.array([shot.pixel_mm, shot.pixel_mm, 1.0])
        write_image(Image(Grid(layers.shape, spacing, np.zeros(3)), layers), files["image"])


def load_mammogram(files: Mapping[str, str]) -> Seen:
    """The row that save_mammogram wrote."""
    return Seen(read_table(files["row"]).iloc[0].to_dict(), None)


def image_row(inputs: Inputs) -> dict[str, float]:
    """What a mammogram shows, and the dose that it takes, mGy."""
    row = inputs["mammogram"].row
    return {**row, **asdict(ExposedDose.of(inputs["dose"], row["mas"]))}


def save_image_row(row: Mapping[str, float], files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """That row."""
    write_table(pd.DataFrame([{**job, **row}]), files["row"])


@dataclass(frozen=True)
class Views:
    """-ln(I / I0) of the views over an arc, taken with mas in all, and the grid and masks of their slices."""

    arc: Arc
    integrals: list[np.ndarray]
    mas: float
    grid: Grid
    masks: Masks


def views(inputs: Inputs) -> Views:
    """The views of tomosynthesis. Raises MissingResult where the detector does not hold the breast."""
    require_held(inputs["field"], TOMOSYNTHESIS)
    labels, given, streams = inputs["phantom"], _scan(inputs), inputs.subject.streams
    imaging = {
        "chest_y_mm": inputs["pressed"].plates["chest_y_mm"],
        "equipment": _equipment(inputs),
        "steps": _names(inputs),
        "seed": streams[0],
    }
    system = system_named(given.system)
    scatter: tuple[ScatterAt, ...] = ()
    if inputs.has("scatter"):
        cell_mm = inputs.setting("xray.scatter_pixel_mm")
        coarse = Arc.of(labels, system, inputs["spectrum"], pixel_mm=cell_mm, **imaging)
        error = inputs.setting("xray.scatter_error_percent") / PERCENT
        stream = seed_of(*streams, "arc")
        scatter = coarse.scattered(labels, given.scatter_views, relative_error=error, seed=stream)
    arc = Arc.of(labels, system, inputs["spectrum"], pixel_mm=given.pixel_mm, **imaging)
    mas = given.exposure_share * inputs["exposure"]
    b = arc.integrals(labels, mas=mas, scatter=scatter, rng=generator(*streams, "views"))
    grid = slices_grid(labels, voxel_mm=given.pixel_mm, slice_mm=given.slice_mm)
    return Views(arc, b, mas, grid, Masks.of(labels, grid))


@dataclass(frozen=True)
class Slices:
    """A row per method with the lesion's contrast-to-noise ratio; images: empty where read from a file."""

    rows: pd.DataFrame
    images: Mapping[str, Image]

    def cnr(self, method: str) -> float:
        """Of the lesion in its slice."""
        return float(self.rows.set_index("method").cnr[method])


def slices(inputs: Inputs) -> Slices:
    """The views reconstructed by each method."""
    seen, rows, images = inputs["views"], [], {}
    for method, reconstructed in _methods(inputs).items():
        found = reconstructed(seen.integrals, seen.arc.geometries, seen.grid).image
        rows.append(
            {"method": method, "views": seen.arc.system.views, "mas": seen.mas} | seen.masks.row(found)
        )
        images[method] = Image(seen.grid, found.values.astype(np.float32))
    return Slices(pd.DataFrame(rows), images)


def save_slices(found: Slices, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The rows, and the slices."""
    write_table(found.rows.assign(**job)[[*job, *found.rows.columns]], files["rows"])
    for method, slices in found.images.items():
        write_image(slices, files[method])


def load_slices(files: Mapping[str, str]) -> Slices:
    """The rows that save_slices wrote."""
    return Slices(read_table(files["rows"]), {})


def depth(inputs: Inputs) -> pd.DataFrame:
    """How deep the lesion is smeared by each method: chain.tomosynthesis.Masks.profile, free of noise."""
    seen, labels = inputs["views"], inputs["phantom"]
    profiles = []
    for method, reconstructed in _methods(inputs).items():
        lesion = lesion_alone(seen.arc, labels, seen.grid, reconstructed)
        profiles.append(seen.masks.profile(lesion).assign(method=method))
    return pd.concat(profiles)


def save_depth(table: pd.DataFrame, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The profiles."""
    write_table(table, files["profiles"])


def _methods(inputs: Inputs) -> Mapping[str, Reconstruction]:
    iterative = partial(sart, iterations=_scan(inputs).iterations)
    return {"filtered_backprojection": filtered_backprojection, "sart": iterative}


def _names(inputs: Inputs) -> tuple[str, ...]:
    """The steps that are there, in the order in which they act."""
    return tuple(name for name in (*BEFORE, *STEPS) if inputs.has(name))


def _equipment(inputs: Inputs) -> Equipment:
    own = {name: inputs.setting(f"xray.{name}") for name in annotations(Equipment) if name != "tube"}
    return read(Equipment, own | {"tube": looked_up(Tube, inputs.setting, "xray")}, "xray")


def _scan(inputs: Inputs) -> ScanSettings:
    return read(ScanSettings, inputs.setting("xray.tomosynthesis"), "xray.tomosynthesis")
