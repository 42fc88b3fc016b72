"""Processor time of every program and X-ray task, with the goals."""

import _log

from mammosim.figures.peers_xray import tasks
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, targets: str, out: str) -> None:
    write_figure(tasks(read_table(table), read_table(targets)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.input.targets, snakemake.output[0])
