"""From supine to prone with one modulus: a row of table 1.2 of Mira 2018, and the predicted shape."""

import _stage
import numpy as np
import pandas as pd

from mammosim.core.positions import gravity_vector
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.study.sweep import one_law, reposition, sweep_row

NIPPLES = ("nipple_left", "nipple_right")


def main(files: dict[str, str], volunteer: str, kpa: float, settings: dict, gravity: list[str]) -> None:
    mesh = read_mesh(files["mesh"])
    start, goal = (read_fiducials(files[name]) for name in ("start", "goal"))
    tissues = one_law(kpa, **settings)
    supine, prone = map(gravity_vector, gravity)
    prone = read_transform(files["transform"]).R @ prone
    repositioned = reposition(mesh, tissues, gravity=supine, new_gravity=prone)
    row = sweep_row(
        volunteer,
        tissues,
        mesh,
        repositioned,
        nipples=np.array([start.point(name) for name in NIPPLES]),
        goal=np.array([goal.point(name) for name in NIPPLES]),
    )
    write_table(pd.DataFrame([row]), files["row"])
    write_mesh(mesh, files["shape"], point_data={"rest": repositioned.rest, "predicted": repositioned.points})


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            float(snakemake.wildcards.kpa),
            snakemake.params.settings,
            snakemake.params.gravity,
        )
