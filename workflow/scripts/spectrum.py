"""The spectrum that reaches the breast as a table, with its half-value layer and air kerma."""

import _stage

from mammosim.chain.view import spectrum_table
from mammosim.io.tables import write_json, write_table
from mammosim.xray.quality import Paddle, in_the_way
from mammosim.xray.tube import tube_spectrum


def main(tube: dict, spectrum: str, facts: str) -> None:
    full = tube_spectrum(tube["anode"], tube["filter"], tube["filter_um"] / 1e3, tube["peak_kv"])
    behind = in_the_way(full, (Paddle(**tube["paddle"]),))
    table, values = spectrum_table(behind.rebinned(tube["energies"]))
    write_table(table, spectrum)
    write_json(values | {"hvl_before_paddle_mm_al": full.hvl_mm_al}, facts)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.params.tube, snakemake.output.spectrum, snakemake.output.facts)
