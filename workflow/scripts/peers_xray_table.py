"""All programs and X-ray tasks in one table, and what was aimed at; what was missed, on the terminal."""

import sys

import _log
import pandas as pd

from mammosim.io.tables import read_table, write_json, write_table
from mammosim.study.peers.xray_summary import numbers, targets


def main(rows: list[str], aims: list[dict], out: dict[str, str]) -> None:
    table = pd.concat([read_table(path) for path in rows], ignore_index=True)
    reached = targets(table, aims)
    write_table(table, out["table"])
    write_table(reached, out["targets"])
    write_json(numbers(table, reached), out["numbers"])
    for row in reached[~reached.met].itertuples():
        sys.stderr.write(f"not reached: {row.what}, {row.task}: {row.measured:.3g}, {row.goal}\n")


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.params.aims, out=dict(snakemake.output.items()))
