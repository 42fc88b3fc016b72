"""The rigid motion of one position into the reference frame, applied to its image and fiducials."""

import _stage
import pandas as pd

from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import IDENTITY
from mammosim.imaging.registration import Settings, register, resample
from mammosim.io.fiducials import read_fiducials, write_fiducials
from mammosim.io.images import read_image, write_image
from mammosim.io.tables import write_table
from mammosim.io.transforms import write_transform

COLUMNS = ["volunteer", "position", "step", "marker_residual_mm", "correlation", "iterations", "used"]


def main(files: dict[str, str], volunteer: str, position: str, settings: Settings) -> None:
    fixed, moving = read_image(files["fixed"]), read_image(files["moving"])
    fiducials = read_fiducials(files["moving_fiducials"])
    if files["fixed"] == files["moving"]:
        motion, steps = IDENTITY, pd.DataFrame(columns=COLUMNS)
    else:
        markers = read_fiducials(files["fixed_fiducials"]).of_kind("chest")
        found = register(fixed, moving, markers, fiducials.of_kind("chest"), settings=settings)
        motion, steps = found.refined, found.table
        steps.insert(0, "volunteer", volunteer)
        steps.insert(1, "position", position)
    write_transform(motion, files["transform"])
    write_image(resample(moving, motion, fixed.grid), files["image"])
    moved = Fiducials(fiducials.names, fiducials.kinds, motion(fiducials.points))
    write_fiducials(moved, files["fiducials"])
    write_table(steps, files["steps"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            snakemake.wildcards.p,
            Settings(**snakemake.params.settings),
        )
