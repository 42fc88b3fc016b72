"""Spectra of mammographic beams."""

import _log

from mammosim.figures.spectra import spectra
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(files: dict[str, str], out: str) -> None:
    write_figure(spectra(read_table(files["spectra"]), read_table(files["quality"])), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), snakemake.output[0])
