"""All programs in one table, and how far the targets are reached; those missed are named on the terminal."""

import sys

import _log
import _stage
import pandas as pd

from mammosim.core.settings import read
from mammosim.io.tables import read_table, write_numbers, write_table
from mammosim.study.peers import summary


def main(
    rows: list[str], targets: dict | list, out: dict[str, str], stopping: dict[str, str] | None = None
) -> None:
    """stopping: the criteria of the programs of the mechanics, none of the X-ray tasks."""
    table = pd.concat([read_table(path) for path in rows], ignore_index=True)
    if stopping is None:
        wanted, numbers = read(tuple[summary.XrayTarget, ...], targets, "xray.targets"), summary.xray_numbers
    else:
        wanted, numbers = read(summary.MechanicsTargets, targets, "targets").all(), summary.numbers
        table = summary.with_agreement(table).assign(stopping=table.program.map(stopping))
    reached = summary.reached(table, wanted)
    write_table(table, out["table"])
    write_table(reached, out["targets"])
    write_numbers(numbers(table, reached), out["numbers"])
    for row in reached[~reached.met].itertuples():
        sys.stderr.write(f"not reached: {row.what}, {row[2]}: {row.measured:.3g}, {row.target}\n")


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, **_stage.settings(snakemake), out=dict(snakemake.output.items()))
