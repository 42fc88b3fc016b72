"""Reject images, labels, a fiducial list or strokes that cannot be used, before anything long runs."""

import logging

import _log
import numpy as np
import pandas as pd

from mammosim.chain.labelled import outline_image, usable_labels
from mammosim.core.errors import FiducialError, ImageError, SegmentationError
from mammosim.core.volume import Image
from mammosim.imaging.markers import chest_markers, require_four
from mammosim.imaging.plausible_points import require_plausible
from mammosim.imaging.plausible_strokes import require_painted
from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_labels
from mammosim.io.scans import read_scan
from mammosim.io.strokes import read_strokes
from mammosim.io.tables import write_table


def main(
    files: dict[str, str],
    job: dict,
    gravity: np.ndarray,
    *,
    found: bool,
    registered: bool,
    how: dict[str, str],
    sides: list[str],
    out: str,
) -> None:
    given = [
        usable(files[kind], kind, job["position"], gravity, how)
        for kind in ("labels", "images")
        if kind in files
    ]
    image = given[-1]  # an image tells more than the outline of labels
    if "listed" in files:
        check_list(files["listed"], image, found=found, registered=registered, sides=sides)
    if "strokes" in files and "labels" not in files:  # given labels stand in the place of a segmentation
        check_strokes(files["strokes"], image)
    write_table(pd.DataFrame([job | image_quality(image, position=job["position"])]), out)


def usable(path: str, kind: str, position: str, gravity: np.ndarray, how: dict[str, str]) -> Image:
    """The image, or the outline of the labels. Raises ImageError, which names the file."""
    image, tag = pictured(path, kind, how)
    try:
        require_usable(image, position=position, gravity=gravity, patient_position=tag)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None
    return image


def pictured(path: str, kind: str, how: dict[str, str]) -> tuple[Image, str | None]:
    """What a file shows, and the PatientPosition tag of a series."""
    if kind == "labels":
        return outline_image(usable_labels(read_labels(path), path)), None
    scan = read_scan(path, **how)
    for note in scan.notes:
        logging.info("%s: %s", path, note)
    return scan.image, scan.patient_position


def check_list(path: str, image: Image, *, found: bool, registered: bool, sides: list[str]) -> None:
    """Raise FiducialError for points that cannot be meant in the image, and for names that are needed.

    Those are the nipples of the sides, and four chest markers where positions are brought together by them.
    """
    listed = read_fiducials(path)
    try:
        listed.require(f"nipple_{side}" for side in sides)
        require_plausible(listed, image)
        if registered:
            listed = chest_markers(image, listed) if found else listed
            require_four(listed.of_kind("chest"))
    except FiducialError as error:
        raise FiducialError(f"{path} with its image: {error}") from None


def check_strokes(path: str, image: Image) -> None:
    """Raise SegmentationError for strokes that cannot be meant in the image."""
    strokes = read_strokes(path)
    try:
        require_painted(strokes, image)
    except SegmentationError as error:
        raise SegmentationError(f"{path}: {error}") from None


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {name: path for name, path in snakemake.input.items() if path},
        {"volunteer": snakemake.wildcards.v, "position": snakemake.wildcards.p},
        np.array(snakemake.params.gravity.split(), float),
        found=snakemake.params.chest_markers == "found",
        registered=snakemake.params.registered,
        how=snakemake.params.how,
        sides=snakemake.params.sides,
        out=snakemake.output[0],
    )
