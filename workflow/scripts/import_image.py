"""Import one DICOM series or NIfTI image."""

from pathlib import Path

import _log

from mammosim.io.dicom import read_series
from mammosim.io.images import read_image, write_image


def main(images: str, out: str) -> None:
    write_image(read_series(images).image if Path(images).is_dir() else read_image(images), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.images, snakemake.output[0])
