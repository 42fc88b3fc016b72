"""What the study asked for and did not get, with the reasons."""

from pathlib import Path

import _log

from mammosim.io.figures import missing_reason
from mammosim.io.tables import read_rows, write_table
from mammosim.study.jobs.completeness import missing_results


def main(tables: list[str], pictures: list[str], out: str) -> None:
    figures = {Path(path).stem: missing_reason(path) for path in pictures}
    write_table(missing_results({Path(path).stem: read_rows(path) for path in tables}, figures), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.tables, snakemake.input.pictures, snakemake.output[0])
