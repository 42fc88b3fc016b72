"""The spectrum of the tube as a table, with its half-value layer and air kerma."""

import _log
import pandas as pd

from mammosim.io.tables import write_json, write_table
from mammosim.xray.tube import tube_spectrum


def main(tube: dict, table: str, facts: str) -> None:
    spectrum = tube_spectrum(tube["anode"], tube["filter"], tube["filter_um"] / 1e3, tube["peak_kv"])
    spectrum = spectrum.rebinned(tube["energies"])
    columns = {"energy_kev": spectrum.energies_kev, "photons_per_mm2_mas": spectrum.fluence}
    write_table(pd.DataFrame(columns), table)
    write_json(
        {
            "name": spectrum.name,
            "distance_mm": spectrum.distance_mm,
            "hvl_mm_al": spectrum.hvl_mm_al,
            "mean_energy_kev": spectrum.mean_energy_kev,
            "kerma_mgy_per_mas": spectrum.kerma_mgy_per_mas,
        },
        facts,
    )


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.params.tube, snakemake.output.spectrum, snakemake.output.facts)
