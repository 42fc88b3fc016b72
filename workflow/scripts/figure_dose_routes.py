"""Glandular dose by every route, of the study's breasts and of standard ones."""

import _stage

from mammosim.figures.dose_routes import dose_routes
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(files: dict[str, str], out: str) -> None:
    write_figure(dose_routes(read_table(files["routes"]), read_table(files["standard"])), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.output[0])
