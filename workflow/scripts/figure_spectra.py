"""Spectra of mammographic beams."""

import _stage

from mammosim.figures.spectra import spectra
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(files: dict[str, str], out: str) -> None:
    write_figure(spectra(read_table(files["spectra"]), read_table(files["quality"])), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.output[0])
