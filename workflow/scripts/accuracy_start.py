"""The chain of one breast at today's settings, which every trial of accuracy begins with."""

import _log

from mammosim.chain.files import chain_of
from mammosim.io.tables import write_table
from mammosim.study.accuracy.trial import made_today, write_start


def main(files: dict, given: dict, quantities: list[str], folder: str, table: str) -> None:
    chain, rows = made_today(chain_of(given, files), quantities)
    write_start(chain, folder)
    write_table(rows, table)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        snakemake.params.given,
        snakemake.params.quantities,
        snakemake.output.folder,
        snakemake.output.table,
    )
