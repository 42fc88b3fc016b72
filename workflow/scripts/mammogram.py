"""The X-ray image of one compressed breast with a lesion, and how well lesion and calcifications show."""

import _stage
import numpy as np
import pandas as pd

from mammosim.chain.calcifications import Search, cluster_row
from mammosim.chain.field import MAMMOGRAM, require_held
from mammosim.chain.image_chain import Taken
from mammosim.chain.mammogram import View, mammogram, scatter_from
from mammosim.chain.view import craniocaudal, spectrum_from
from mammosim.core.rng import generator
from mammosim.core.volume import Grid, Image
from mammosim.io.images import read_labels, write_image
from mammosim.io.tables import read_json, read_table, write_table


def main(files: dict, settings: dict, job: dict, seed: int) -> None:
    require_held(read_table(files["field"]), MAMMOGRAM)
    labels, plates = read_labels(files["phantom"]), read_json(files["plates"])
    geometry = craniocaudal(labels, chest_y_mm=plates["chest_y_mm"], **settings["geometry"])
    middle = settings["geometry"]["support_to_detector_mm"] + plates["thickness_mm"] / 2
    view = View(
        Taken(geometry, middle, settings["chain"] | {"seed": seed}),
        spectrum_from(read_table(files["spectrum"]), read_json(files["facts"])),
        settings["detector_kerma_ugy"] / 1e3,
        tuple(settings["effects"]),
        scatter_from(read_table(*files["scatter"]), geometry) if files["scatter"] else None,
        settings["rays_per_pixel"],
    )
    shot = mammogram(labels, view, rng=generator(seed, *job.values(), "quantum noise"))
    search = Search.drawn(**settings["calcifications"], rng=generator(seed, "calcifications"))
    stream = generator(seed, *job.values(), "cluster")
    cluster = cluster_row(labels, view, search, mas=shot.row["mas"], rng=stream)
    dose = read_table(files["dose"]).iloc[0]
    doses = {"dose_mgy": dose.mgy_per_mas, "dose_se_mgy": dose.standard_error_mgy_per_mas}
    row = job | shot.row | cluster | {name: value * shot.row["mas"] for name, value in doses.items()}
    write_table(pd.DataFrame([row]), files["row"])
    pixel = geometry.detector.pixel_mm
    layers = np.stack([shot.exposure.image, shot.lesion, shot.ring]).astype(np.float32)
    write_image(Image(Grid(layers.shape, np.array([pixel, pixel, 1.0]), np.zeros(3)), layers), files["image"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        job = {"volunteer": snakemake.wildcards.v} | {
            name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")
        }
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            dict(snakemake.params.items()),
            job,
            snakemake.params.seed,
        )
