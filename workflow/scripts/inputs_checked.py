"""Join the quality rows of all images; every fiducial list has been checked by then."""

import _log
import pandas as pd

from mammosim.io.tables import read_table, write_table


def main(quality: list[str], out: str) -> None:
    write_table(pd.concat([read_table(path) for path in quality], ignore_index=True), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.quality, snakemake.output[0])
