"""Slices of one compressed breast by tomosynthesis: views with noise and scatter, two reconstructions."""

import time
from functools import partial

import _stage
import numpy as np
import pandas as pd

from mammosim.chain.field import TOMOSYNTHESIS, require_held
from mammosim.chain.tomosynthesis import Arc, Masks, lesion_alone, slices_grid
from mammosim.chain.view import spectrum_from
from mammosim.core.rng import generator, seed_of
from mammosim.core.volume import Image
from mammosim.io.images import read_labels, write_image
from mammosim.io.tables import read_json, read_table, write_table
from mammosim.xray.reconstruction import filtered_backprojection, sart
from mammosim.xray.systems import system_named


def main(files: dict[str, str], settings: dict, job: dict, seed: int) -> None:
    require_held(read_table(files["field"]), TOMOSYNTHESIS)
    labels, plates = read_labels(files["phantom"]), read_json(files["plates"])
    spectrum = spectrum_from(read_table(files["spectrum"]), read_json(files["facts"]))
    given, system = settings["scan"], system_named(settings["scan"]["system"])
    seen = {"chest_y_mm": plates["chest_y_mm"], "settings": settings["chain"] | {"seed": seed},
            "effects": settings["effects"]}  # fmt: skip
    clock, scatter = time.perf_counter(), ()
    if "scatter" in settings["effects"]:
        coarse = Arc.of(labels, system, spectrum, pixel_mm=settings["scatter_pixel_mm"], **seen)
        error, stream = settings["scatter_error_percent"] / 100, seed_of(seed, *job.values(), "arc")
        scatter = coarse.scattered(labels, given["scatter_views"], relative_error=error, seed=stream)
    mas = given["exposure_share"] * float(read_table(files["image"]).mas.iloc[0])
    arc = Arc.of(labels, system, spectrum, pixel_mm=given["pixel_mm"], **seen)
    b = arc.integrals(labels, mas=mas, scatter=scatter, rng=generator(seed, *job.values(), "views"))
    grid = slices_grid(labels, voxel_mm=given["pixel_mm"], slice_mm=given["slice_mm"])
    masks, rows, profiles = Masks.of(labels, grid), [], []
    methods = {
        "filtered_backprojection": filtered_backprojection,
        "sart": partial(sart, iterations=given["iterations"]),
    }
    for method, reconstructed in methods.items():
        slices = reconstructed(b, arc.geometries, grid).image
        rows.append(job | {"method": method, "views": system.views, "mas": mas} | masks.row(slices))
        lesion = lesion_alone(arc, labels, grid, reconstructed)
        profiles.append(masks.profile(lesion).assign(method=method))
        write_image(Image(grid, slices.values.astype(np.float32)), files[method])
    write_table(pd.DataFrame(rows).assign(seconds=time.perf_counter() - clock), files["rows"])
    write_table(pd.concat(profiles), files["profiles"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        names = {name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")}
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            dict(snakemake.params.items()),
            {"volunteer": snakemake.wildcards.v} | names,
            snakemake.params.seed,
        )
