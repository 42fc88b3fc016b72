"""Reject an image or a fiducial list that cannot be used before anything long runs; note its quality."""

from pathlib import Path

import _log
import numpy as np
import pandas as pd

from mammosim.core.errors import FiducialError, ImageError
from mammosim.imaging.markers import chest_markers, require_four
from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.dicom import read_series
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_image
from mammosim.io.tables import write_table


def main(files: dict[str, str], job: dict, gravity: np.ndarray, *, found: bool, out: str) -> None:
    images, position = files["images"], job["position"]
    if Path(images).is_dir():
        series = read_series(images)
        image, tag = series.image, series.patient_position
    else:
        image, tag = read_image(images), None
    try:
        require_usable(image, position=position, gravity=gravity, patient_position=tag)
    except ImageError as error:
        raise ImageError(f"{images}: {error}") from None
    try:
        listed = read_fiducials(files["listed"])
        listed = chest_markers(image, listed) if found else listed
        require_four(listed.of_kind("chest"))
    except FiducialError as error:
        raise FiducialError(f"{images} with {files['listed']}: {error}") from None
    write_table(pd.DataFrame([job | image_quality(image, position=position)]), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        {"volunteer": snakemake.wildcards.v, "position": snakemake.wildcards.p},
        np.array(snakemake.params.gravity.split(), float),
        found=snakemake.params.chest_markers == "found",
        out=snakemake.output[0],
    )
