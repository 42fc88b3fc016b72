"""Scan a digital volunteer: a DICOM series, what a person clicks and paints in it, and the true labels."""

from pathlib import Path

import _log
import numpy as np

from mammosim.core.volume import Grid, grid_around
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.annotator import clicked, strokes
from mammosim.digital.body import Loaded
from mammosim.digital.signal import Scan, render, truth_labels
from mammosim.io.dicom_writer import write_series
from mammosim.io.fiducials import write_fiducials
from mammosim.io.images import write_labels
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_json, write_table
from mammosim.io.transforms import read_transform


def main(files: dict[str, str], settings: dict, volunteer: str, position: str) -> None:
    mesh, x = read_mesh(files["mesh"]), read_mesh(files["loaded"]).points
    body = Loaded(make_anatomy(read_json(files["woman"])), read_transform(files["motion"]), mesh, x)
    stream = (settings["seed"], volunteer, position)
    scan, grid = scan_of(settings["scan"])
    labels = truth_labels(body, grid, scan=scan)
    write_labels(labels, files["labels"])
    points = clicked(body, scan=scan, error_mm=settings["click_error_mm"], stream=stream)
    write_fiducials(points, files["fiducials"])
    paint = settings["strokes"]
    painted = strokes(
        labels, paint["z_mm"], per_tissue=paint["per_tissue"], steps=paint["steps"], stream=stream
    )
    write_table(painted, files["strokes"])
    Path(files["series"]).mkdir(parents=True, exist_ok=True)
    write_series(
        Path(files["series"]),
        render(body, grid, scan=scan, stream=stream),
        position=position,
        volunteer=volunteer,
        echo_time_ms=scan.echo_time_ms,
        repetition_time_ms=scan.repetition_time_ms,
    )


def scan_of(values: dict) -> tuple[Scan, Grid]:
    """The scan's settings and its grid from configured values."""
    scan = Scan(
        echo_time_ms=values["echo_time_ms"],
        repetition_time_ms=values["repetition_time_ms"],
        adipose=values["fat_intensity"],
        bias=values["bias_percent"] / 100,
        noise=values["noise_percent"] / 100,
        subsamples=values["subvoxels"],
        marker_mm=values["marker_mm"],
    )
    low, high = np.array([values["field_of_view_mm"][axis] for axis in "xyz"], float).T
    return scan, grid_around(low, high, np.array(values["spacing_mm"], float))


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()) | dict(snakemake.output.items()),
        dict(snakemake.params.items()),
        snakemake.wildcards.w,
        snakemake.wildcards.p,
    )
