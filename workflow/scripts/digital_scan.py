"""Scan a virtual patient: a DICOM series, what a person clicks and paints in it, and the true labels."""

from pathlib import Path

import _log
import _stage

from mammosim.core.settings import read
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.annotator import Painting, clicked, strokes
from mammosim.digital.body import Loaded
from mammosim.digital.patient import VirtualPatient
from mammosim.digital.signal import ScanSettings, render, truth_labels
from mammosim.io.dicom_writer import write_series
from mammosim.io.fiducials import write_fiducials
from mammosim.io.images import write_labels
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_json, write_table
from mammosim.io.transforms import read_transform


def main(files: dict[str, str], settings: dict, volunteer: str, position: str) -> None:
    patient = VirtualPatient.read(read_json(files["woman"]))
    mesh, x = read_mesh(files["mesh"]), read_mesh(files["loaded"]).points
    body = Loaded(make_anatomy(patient), read_transform(files["motion"]), mesh, x)
    stream = (settings["seed"], volunteer, position)
    scanned = read(ScanSettings, settings["scan"], "digital.scan")
    scan, grid = scanned.scan, scanned.grid
    labels = truth_labels(body, grid, scan=scan)
    write_labels(labels, files["labels"])
    points = clicked(body, scan=scan, error_mm=settings["click_error_mm"], stream=stream)
    write_fiducials(points, files["fiducials"])
    painting = read(Painting, settings["strokes"], "digital.strokes")
    write_table(strokes(labels, painting, stream=stream), files["strokes"])
    Path(files["series"]).mkdir(parents=True, exist_ok=True)
    write_series(
        Path(files["series"]),
        render(body, grid, scan=scan, stream=stream),
        position=position,
        volunteer=volunteer,
        echo_time_ms=scan.echo_time_ms,
        repetition_time_ms=scan.repetition_time_ms,
    )


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()) | dict(snakemake.output.items()),
        _stage.settings(snakemake),
        snakemake.wildcards.w,
        snakemake.wildcards.p,
    )
