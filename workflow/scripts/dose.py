"""Glandular dose of one compressed breast by photon Monte Carlo."""

from dataclasses import asdict

import _stage
import pandas as pd

from mammosim.chain.field import MAMMOGRAM, require_held
from mammosim.chain.mammogram import dose_in
from mammosim.chain.view import craniocaudal, spectrum_from
from mammosim.core.rng import seed_of
from mammosim.io.images import read_labels
from mammosim.io.tables import read_json, read_table, write_table


def main(files: dict[str, str], settings: dict, job: dict, seed: int) -> None:
    require_held(read_table(files["field"]), MAMMOGRAM)
    labels, plates = read_labels(files["phantom"]), read_json(files["plates"])
    dose = dose_in(
        labels,
        craniocaudal(labels, chest_y_mm=plates["chest_y_mm"], **settings["geometry"]),
        spectrum_from(read_table(files["spectrum"]), read_json(files["facts"])),
        relative_error=settings["dose_error_percent"] / 100,
        seed=seed,
    )
    row = job | asdict(dose) | {"mgy_per_mgy": dose.mgy_per_mgy, "relative_error": dose.relative_error}
    write_table(pd.DataFrame([row]), files["dose"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        job = {"volunteer": snakemake.wildcards.v} | {
            name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")
        }
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            dict(snakemake.params.items()),
            job,
            seed_of(snakemake.params.seed, *job.values(), "photons"),
        )
