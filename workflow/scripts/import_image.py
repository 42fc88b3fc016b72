"""Import one DICOM series or image file."""

import logging

import _log

from mammosim.io.images import write_image
from mammosim.io.scans import read_scan


def main(images: str, how: dict[str, str], out: str) -> None:
    scan = read_scan(images, **how)
    for note in scan.notes:
        logging.info("%s: %s", images, note)
    write_image(scan.image, out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.images, snakemake.params.how, snakemake.output[0])
