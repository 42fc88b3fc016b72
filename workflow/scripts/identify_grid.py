"""What is left of skin and markers on a grid of two moduli: a grid search."""

import _stage

from mammosim.core.fiducials import midline_mm
from mammosim.core.settings import read
from mammosim.io.tables import write_table
from mammosim.study.identification.fit import grid_table
from mammosim.study.identification.moduli import Materials
from mammosim.study.identification.pair import read_pair
from mammosim.study.identification.problem import Problem
from mammosim.study.identification.settings import Grid, Prior


def main(files: dict[str, str], volunteer: str, gravity: list[str], tissues: dict, settings: dict) -> None:
    prior, grid = (
        read(Prior, settings["prior"], "identification.prior"),
        read(Grid, settings["grid"], "identification.grid"),
    )
    pair, assumed = read_pair(files, gravity), read(Materials, tissues, "tissues")
    middle = midline_mm(pair.start.fiducials)
    table = grid_table(Problem(pair, assumed, prior, middle_mm=middle), grid)
    table.insert(0, "volunteer", volunteer)
    write_table(table, files["grid"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | {"grid": snakemake.output[0]},
            snakemake.wildcards.v,
            snakemake.params.gravity,
            snakemake.params.tissues,
            snakemake.params.settings,
        )
