"""Glandular dose of the standard breasts by Monte Carlo and by Dance's factors."""

import _stage

from mammosim.chain.beam import spectrum_from
from mammosim.io.tables import read_json, read_table, write_table
from mammosim.xray.dose_routes import Beam, standard_rows


def main(files: dict[str, str], settings: dict, seed: int) -> None:
    beam = Beam(
        spectrum_from(read_table(files["spectrum"]), read_json(files["facts"])), settings["combination"]
    )
    error = settings["dose_error_percent"] / 100
    write_table(standard_rows(beam, relative_error=error, seed=seed), files["rows"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            _stage.settings(snakemake),
            snakemake.params.seed,
        )
