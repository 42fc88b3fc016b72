"""The end of a campaign, with table and page made: the run fails where the program itself did in a point."""

from collections.abc import Iterable
from pathlib import Path

import _log

from mammosim.io.atomic import replacing
from mammosim.io.tables import read_json
from mammosim.study.campaigns.answers import PointsFailed, faults


def main(batches: Iterable[str], table: str, out: str) -> None:
    found = {path: read_json(path) for path in batches}
    failed = {path: named for path, rows in found.items() if (named := faults(rows))}
    for path in failed:
        # So the same command computes its points again, those that are kept aside.
        Path(path).unlink()
    if failed:
        raise PointsFailed.of([name for names in failed.values() for name in names], table=table)
    with replacing(out) as temporary:
        temporary.write_text(f"{sum(map(len, found.values()))} points\n", encoding="utf-8")


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.batches, snakemake.input.table, snakemake.output[0])
