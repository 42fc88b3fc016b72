"""The quality of the study's beam beside that of every usual target and filter, and their spectra."""

import _stage
import pandas as pd

from mammosim.chain.beam import COLUMNS
from mammosim.io.tables import write_table
from mammosim.io.tabulated import tabulated
from mammosim.xray.quality import Paddle, quality_table
from mammosim.xray.tube import tube_spectrum


def main(tube: dict, quality: str, spectra: str) -> None:
    own = tube_spectrum(tube["anode"], tube["filter"], tube["filter_um"] / 1e3, tube["peak_kv"])
    usual = tabulated("tube_combinations")
    others = [tube_spectrum(r.anode, r.filter, r.usual_mm, tube["peak_kv"]) for r in usual.itertuples()]
    beams = [own, *(beam for beam in others if beam.name != own.name)]
    write_table(quality_table(beams, (Paddle(**tube["paddle"]),)), quality)
    parts = [
        pd.DataFrame(dict(zip(COLUMNS, (beam.energies_kev, beam.fluence)))).assign(beam=beam.name)
        for beam in beams
    ]
    write_table(pd.concat(parts), spectra)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.params.tube, snakemake.output.quality, snakemake.output.spectra)
