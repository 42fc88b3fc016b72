"""Reject images, labels or a fiducial list that cannot be used, before anything long runs."""

import logging
from collections.abc import Callable
from pathlib import Path

import _log
import numpy as np
import pandas as pd

from mammosim.chain.given_labels import LabelSettings, prepared
from mammosim.chain.labelled import outline_image
from mammosim.chain.meshed import ElementEdges
from mammosim.core.errors import FiducialError, ImageError
from mammosim.core.settings import read
from mammosim.core.units import MM3_PER_CM3
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.markers import chest_markers, require_four
from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.dicom import read_series
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_image
from mammosim.io.label_maps import read_label_map
from mammosim.io.tables import write_table
from mammosim.meshing.body import thin_volume

LEAST_THIN_CM3 = 1.0


def main(
    files: dict[str, str],
    job: dict,
    gravity: np.ndarray,
    *,
    found: bool,
    registered: bool,
    taken: Callable[[str], tuple[LabelMap, list[str]]],
    out: str,
) -> None:
    labels, notes = taken(files["labels"]) if "labels" in files else (None, [])
    given = [
        usable(files[kind], kind, job["position"], gravity, labels)
        for kind in ("labels", "images")
        if kind in files
    ]
    image = given[-1]  # an image tells more than the outline of labels
    if "listed" in files:
        check_list(files["listed"], image, found=found, registered=registered)
    quality = image_quality(image, position=job["position"]) | {"notes": "; ".join(notes)}
    write_table(pd.DataFrame([job | quality]), out)


def taken_by(settings: dict, element_mm: dict) -> Callable[[str], tuple[LabelMap, list[str]]]:
    """A reader of label maps, and of what is to be said about them."""

    def taken(path: str) -> tuple[LabelMap, list[str]]:
        found = prepared(read_label_map(path), read(LabelSettings, settings, "labels"))
        thin = thin_volume(found.labels, read(ElementEdges, element_mm, "mesh.element_mm").size) / MM3_PER_CM3
        more = [f"{thin:.0f} cm3 are thinner than half an element"] if thin >= LEAST_THIN_CM3 else []
        for note in (notes := [*found.notes, *more]):
            logging.info("%s: %s", path, note)
        return found.labels, notes

    return taken


def usable(path: str, kind: str, position: str, gravity: np.ndarray, labels: LabelMap | None = None) -> Image:
    """The image, or the outline of the labels. Raises ImageError, which names the file."""
    image, tag = pictured(path, kind, labels)
    try:
        require_usable(image, position=position, gravity=gravity, patient_position=tag)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None
    return image


def pictured(path: str, kind: str, labels: LabelMap | None = None) -> tuple[Image, str | None]:
    """What a file shows, and the PatientPosition tag of a series."""
    if labels is not None and kind == "labels":
        return outline_image(labels), None
    if Path(path).is_dir():
        series = read_series(path)
        return series.image, series.patient_position
    return read_image(path), None


def check_list(path: str, image: Image, *, found: bool, registered: bool) -> None:
    """Raise FiducialError where positions are brought together by chest markers that are not four."""
    listed = read_fiducials(path)
    if not registered:
        return
    try:
        listed = chest_markers(image, listed) if found else listed
        require_four(listed.of_kind("chest"))
    except FiducialError as error:
        raise FiducialError(f"{path} with its image: {error}") from None


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {name: path for name, path in snakemake.input.items() if path and name != "codes"},
        {"volunteer": snakemake.wildcards.v, "position": snakemake.wildcards.p},
        np.array(snakemake.params.gravity.split(), float),
        found=snakemake.params.chest_markers == "found",
        registered=snakemake.params.registered,
        taken=taken_by(snakemake.params.labels, snakemake.params.element_mm),
        out=snakemake.output[0],
    )
