"""The fiducials of one position: chest markers found in the image or listed, the others from the list."""

import _log

from mammosim.imaging.markers import chest_markers, require_four
from mammosim.io.fiducials import read_fiducials, write_fiducials
from mammosim.io.images import read_image


def main(image: str, listed: str, out: str, *, found: bool) -> None:
    fiducials = read_fiducials(listed)
    if found:
        fiducials = chest_markers(read_image(image), fiducials)
    require_four(fiducials.of_kind("chest"))
    write_fiducials(fiducials, out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.input.image,
        snakemake.input.listed,
        snakemake.output[0],
        found=snakemake.params.chest_markers == "found",
    )
