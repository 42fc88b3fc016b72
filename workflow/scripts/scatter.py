"""Scatter of one compressed breast on the detector by photon Monte Carlo."""

import _stage

from mammosim.chain.field import MAMMOGRAM, require_held
from mammosim.chain.mammogram import scatter_behind, scatter_cells
from mammosim.chain.view import craniocaudal, spectrum_from
from mammosim.core.rng import seed_of
from mammosim.io.images import read_labels
from mammosim.io.tables import read_json, read_table, write_table


def main(files: dict[str, str], settings: dict, seed: int) -> None:
    require_held(read_table(files["field"]), MAMMOGRAM)
    labels, plates = read_labels(files["phantom"]), read_json(files["plates"])
    found = scatter_behind(
        labels,
        craniocaudal(labels, chest_y_mm=plates["chest_y_mm"], **settings["geometry"]),
        spectrum_from(read_table(files["spectrum"]), read_json(files["facts"])),
        relative_error=settings["scatter_error_percent"] / 100,
        cell_mm=settings["scatter_pixel_mm"],
        seed=seed,
    )
    write_table(scatter_cells(found), files["scatter"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        job = [snakemake.wildcards[name] for name in ("v", "side", "strategy", "moduli")]
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            dict(snakemake.params.items()),
            seed_of(snakemake.params.seed, *job, "scatter"),
        )
