"""Our photon transport beside AAPM report 195, case 3."""

import _stage

from mammosim.io.tables import write_table
from mammosim.xray.verification import report195_rows


def main(settings: dict, seed: int, out: str) -> None:
    errors = {name: settings[f"{name}_percent"] / 100 for name in ("total_error", "region_error")}
    write_table(report195_rows(**errors, seed=seed), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.params.settings, snakemake.params.seed, snakemake.output[0])
