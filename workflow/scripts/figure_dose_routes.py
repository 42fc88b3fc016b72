"""Glandular dose by every route, of the study's breasts and of standard ones."""

import _log

from mammosim.figures.dose_routes import dose_routes
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(files: dict[str, str], out: str) -> None:
    write_figure(dose_routes(read_table(files["routes"]), read_table(files["standard"])), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), snakemake.output[0])
