"""Glandular dose of one breast by three routes, and of the standard breasts by two."""

import _stage

from mammosim.chain.mammogram import xray_phantom
from mammosim.chain.view import spectrum_from
from mammosim.core.rng import seed_of
from mammosim.io.images import read_labels
from mammosim.io.tables import read_json, read_table, write_table
from mammosim.xray.dose import GlandularDose
from mammosim.xray.dose_routes import Beam, three_routes


def main(files: dict[str, str], settings: dict, job: dict, seed: int) -> None:
    found = read_table(files["dose"]).iloc[0]
    dose = GlandularDose(**{name: found[name] for name in GlandularDose.__dataclass_fields__})
    beam = Beam(
        spectrum_from(read_table(files["spectrum"]), read_json(files["facts"])), settings["combination"]
    )
    rows = three_routes(
        dose,
        xray_phantom(read_labels(files["phantom"])),
        beam,
        thickness_mm=read_json(files["plates"])["thickness_mm"],
        relative_error=settings["dose_error_percent"] / 100,
        seed=seed,
    )
    write_table(rows.assign(**job)[[*job, *rows.columns]], files["rows"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        names = {name: snakemake.wildcards[name] for name in ("side", "strategy", "moduli")}
        job = {"volunteer": snakemake.wildcards.v} | names
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            dict(snakemake.params.items()),
            job,
            seed_of(snakemake.params.seed, *job.values(), "routes"),
        )
