"""A published model's stress-free shape and upright nipple beside the truth of a digital volunteer."""

import _stage
import pandas as pd

from mammosim.core.errors import MissingResult
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_table, write_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.study.models.scores import nipple_away_mm, score


def main(files: dict, job: dict, out: str) -> None:
    fixed, upright = read_transform(files["motion"]), read_transform(files["upright_motion"])
    true = read_fiducials(files["upright_points"]).point(f"nipple_{job['side']}")
    away = nipple_away_mm(read_table(files["row"]).iloc[0], true, motion=fixed.after(upright.inverse()))
    try:
        shape = read_mesh(files["shape"])
    except MissingResult:  # the row says why
        shape = None
    found = score(shape, read_mesh(files["truth"]), motion=fixed)
    write_table(pd.DataFrame([{**job, **found, "nipple_upright_mm": away}]), out)


if __name__ == "__main__":
    with _stage.run(snakemake) as job:
        main(dict(snakemake.input.items()), job, snakemake.output[0])
