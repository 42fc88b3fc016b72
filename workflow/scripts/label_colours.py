"""What the values of a label map mean, for 3D Slicer and ITK-SNAP."""

import _log

from mammosim.figures.style import TISSUE_COLOURS
from mammosim.io.colours import write_slicer_colours, write_snap_labels


def main(slicer: str, snap: str) -> None:
    write_slicer_colours(TISSUE_COLOURS, slicer)
    write_snap_labels(TISSUE_COLOURS, snap)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.output.slicer, snakemake.output.snap)
