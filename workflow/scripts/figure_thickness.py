"""The thickness of one breast under the paddle, by every strategy."""

import _stage

from mammosim.figures.strategies import thickness_maps
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_if_there, read_json


def main(maps: list[str], plates: str, strategies: list[str], out: str) -> None:
    found = {name: read_if_there(path) for name, path in zip(strategies, maps)}
    if all(rows.empty for rows in found.values()):
        read_json(plates)  # says why the standard is missing, and the others with it
    write_figure(thickness_maps(found), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.maps, snakemake.input.plates, snakemake.params.strategies, snakemake.output[0])
