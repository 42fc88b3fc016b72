"""Force, area and pressure while the plates close."""

import _log

from mammosim.figures.compression import force_thickness
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    paths = {f"{v}, {side}": rows for (v, side), rows in read_table(table).groupby(["volunteer", "side"])}
    write_figure(force_thickness(paths), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.output[0])
