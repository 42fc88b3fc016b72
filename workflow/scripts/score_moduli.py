"""The fitted moduli of a digital volunteer beside the true ones."""

import _stage

from mammosim.io.tables import read_table, write_table
from mammosim.study.identification.scores import scored


def main(files: dict[str, str], seed: int, out: str) -> None:
    seconds = float(read_table(files["fit"]).seconds.iloc[0])
    fitted, truth = read_table(files["fitted"]), read_table(files["truth"])
    write_table(scored(fitted, truth, seed=seed, seconds=seconds), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.params.seed, snakemake.output[0])
