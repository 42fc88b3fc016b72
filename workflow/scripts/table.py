"""One table of the study from the rows of its parts."""

import _log
import pandas as pd

from mammosim.io.tables import read_table, write_table


def main(rows: list[str], out: str) -> None:
    write_table(pd.concat([read_table(path) for path in rows], ignore_index=True), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.output[0])
