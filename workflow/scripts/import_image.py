"""Import one DICOM series or NIfTI image and refuse what cannot be used."""

from pathlib import Path

import _log
import numpy as np
import pandas as pd

from mammosim.imaging.quality import image_quality, require_usable
from mammosim.io.dicom import read_series
from mammosim.io.images import read_image, write_image
from mammosim.io.tables import write_table


def main(files: dict[str, str], volunteer: str, position: str, gravity: np.ndarray) -> None:
    if Path(files["images"]).is_dir():
        series = read_series(files["images"])
        image, tag = series.image, series.patient_position
    else:
        image, tag = read_image(files["images"]), None
    require_usable(image, position=position, gravity=gravity, patient_position=tag)
    write_image(image, files["image"])
    row = {"volunteer": volunteer, "position": position} | image_quality(image, position=position)
    write_table(pd.DataFrame([row]), files["quality"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()) | dict(snakemake.output.items()),
        snakemake.wildcards.v,
        snakemake.wildcards.p,
        np.array(snakemake.params.gravity.split(), float),
    )
