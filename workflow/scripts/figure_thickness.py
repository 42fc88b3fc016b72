"""The thickness of one breast under the paddle, by every strategy."""

import _log

from mammosim.figures.strategies import thickness_maps
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(maps: list[str], strategies: list[str], out: str) -> None:
    write_figure(thickness_maps({name: read_table(path) for name, path in zip(strategies, maps)}), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.maps, snakemake.params.strategies, snakemake.output[0])
