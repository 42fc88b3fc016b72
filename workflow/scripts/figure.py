"""A figure of one or two tables, drawn by a function of mammosim.figures."""

from importlib import import_module

import _stage

from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(function: str, tables: list[str], told: dict, out: str) -> None:
    module, name = function.split(".")
    draw = getattr(import_module(f"mammosim.figures.{module}"), name)
    write_figure(draw(*(read_table(path, may_be_empty=True) for path in tables), **told), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.params.function, snakemake.input.tables, snakemake.params.told, snakemake.output[0])
