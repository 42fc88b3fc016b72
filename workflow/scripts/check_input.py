"""Reject images, labels or a fiducial list that cannot be used, before anything long runs."""

from pathlib import Path

import _log
import numpy as np
import pandas as pd

from mammosim.chain.labelled import outline_image, usable_labels
from mammosim.core.errors import FiducialError, ImageError
from mammosim.core.volume import Image
from mammosim.imaging.markers import worn_on_chest
from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.dicom import read_series
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_image, read_labels
from mammosim.io.tables import write_table


def main(
    files: dict[str, str], job: dict, gravity: np.ndarray, *, found: bool, registered: bool, out: str
) -> None:
    given = [
        usable(files[kind], kind, job["position"], gravity) for kind in ("labels", "images") if kind in files
    ]
    image = given[-1]  # an image tells more than the outline of labels
    if "listed" in files:
        check_list(files["listed"], image, found=found, registered=registered)
    write_table(pd.DataFrame([job | image_quality(image, position=job["position"])]), out)


def usable(path: str, kind: str, position: str, gravity: np.ndarray) -> Image:
    """The image, or the outline of the labels. Raises ImageError, which names the file."""
    image, tag = pictured(path, kind)
    try:
        require_usable(image, position=position, gravity=gravity, patient_position=tag)
    except ImageError as error:
        raise ImageError(f"{path}: {error}") from None
    return image


def pictured(path: str, kind: str) -> tuple[Image, str | None]:
    """What a file shows, and the PatientPosition tag of a series."""
    if kind == "labels":
        return outline_image(usable_labels(read_labels(path), path)), None
    if Path(path).is_dir():
        series = read_series(path)
        return series.image, series.patient_position
    return read_image(path), None


def check_list(path: str, image: Image, *, found: bool, registered: bool) -> None:
    """Raise FiducialError where positions are brought together by chest markers: some, but not four."""
    listed = read_fiducials(path)
    if not registered:
        return
    try:
        worn_on_chest(listed, image if found else None)
    except FiducialError as error:
        raise FiducialError(f"{path} with its image: {error}") from None


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {name: path for name, path in snakemake.input.items() if path},
        {"volunteer": snakemake.wildcards.v, "position": snakemake.wildcards.p},
        np.array(snakemake.params.gravity.split(), float),
        found=snakemake.params.chest_markers == "found",
        registered=snakemake.params.registered,
        out=snakemake.output[0],
    )
