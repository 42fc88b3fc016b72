"""Prone in the shape of supine, and their mean, with the distance left after every level."""

import _stage
import numpy as np
import pandas as pd

from mammosim.chain.morph import MorphSettings, morphed, sound_mean
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import write_table
from mammosim.meshing.distance import surface_distance


def main(files: dict[str, str], volunteer: str, settings: dict) -> None:
    prone, supine = read_mesh(files["prone"]), read_mesh(files["supine"])
    levels = tuple(settings["stiffness_kpa_per_mm"])
    found = morphed(prone, supine, settings=MorphSettings(levels, settings["updates"]))
    mean = sound_mean(prone, found.points)
    table = pd.DataFrame(found.history).assign(mean_share=mean.share)
    table.insert(0, "volunteer", volunteer)
    write_table(table, files["history"])
    body = prone.moved_to(found.points)
    distance = np.zeros(len(body.points))
    distance[body.boundary_nodes("skin")] = surface_distance(body, supine)
    write_mesh(body, files["morphed"], point_data={"distance_mm": distance})
    write_mesh(prone.moved_to(mean.points), files["mean"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            snakemake.params.settings,
        )
