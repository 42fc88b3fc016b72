"""Upright from prone, with or without skin: one row of displacements, and the predicted shape."""

import _stage
import numpy as np
import pandas as pd

from mammosim.core.positions import gravity_direction, gravity_vector
from mammosim.core.rigid import IDENTITY
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform
from mammosim.io.written import read_fiducials
from mammosim.mechanics.body import Skin
from mammosim.study.sweep import one_law, reposition, upright_row


def main(files: dict[str, str], volunteer: str, skin_kpa: float, settings: dict, gravity: str) -> None:
    mesh, fiducials = read_mesh(files["mesh"]), read_fiducials(files["start"])
    tissues = one_law(settings["youngs_modulus_kpa"], **settings["tissue"])
    skin = None
    if skin_kpa > 0:
        skin = Skin(skin_kpa, settings["tissue"]["poisson_ratio"], settings["skin_thickness_mm"])
    motion = read_transform(files["transform"]) if "transform" in files else IDENTITY
    prone = motion.R @ gravity_vector(gravity)
    upright = gravity_direction("upright")
    repositioned = reposition(mesh, tissues, gravity=prone, new_gravity=upright, skin=skin)
    nipples = np.array([fiducials.point(name) for name in ("nipple_left", "nipple_right")])
    row = upright_row(volunteer, tissues, mesh, repositioned, nipples=nipples, skin=skin)
    write_table(pd.DataFrame([row]), files["row"])
    write_mesh(mesh, files["shape"], point_data={"rest": repositioned.rest, "predicted": repositioned.points})


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            {name: path for name, path in snakemake.input.items() if path} | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            float(snakemake.wildcards.skin_kpa),
            snakemake.params.settings | {"tissue": snakemake.params.tissue},
            snakemake.params.gravity,
        )
