"""Import one DICOM series or NIfTI image and refuse what cannot be used."""

from pathlib import Path

import _log
import numpy as np
import pandas as pd

from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.dicom import read_series
from mammosim.io.images import read_image, write_image
from mammosim.io.tables import write_table


def main(images: str, volunteer: str, position: str, gravity: np.ndarray, image_path: str, quality: str) -> None:
    series = read_series(images) if Path(images).is_dir() else None
    image = series.image if series else read_image(images)
    require_usable(image, position=position, gravity=gravity, patient_position=series and series.patient_position)
    write_image(image, image_path)
    row = {"volunteer": volunteer, "position": position} | image_quality(image, position=position)
    write_table(pd.DataFrame([row]), quality)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.input.images,
        snakemake.wildcards.v,
        snakemake.wildcards.p,
        np.array(snakemake.params.gravity.split(), float),
        snakemake.output.image,
        snakemake.output.quality,
    )
