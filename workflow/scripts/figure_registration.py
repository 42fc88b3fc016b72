"""One position over the reference position, before and after registration."""

import _stage

from mammosim.core.rigid import IDENTITY
from mammosim.figures.volunteers import registration
from mammosim.imaging.registration import resample
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.images import read_image
from mammosim.io.tables import read_table


def main(files: dict[str, str], out: str) -> None:
    fixed = read_image(files["fixed"])
    before = resample(read_image(files["moving"]), IDENTITY, fixed.grid)
    z = read_fiducials(files["fiducials"]).point("nipple_left")[2]
    figure = registration(fixed, before, read_image(files["after"]), read_table(files["steps"]), at_mm=z)
    write_figure(figure, out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.output[0])
