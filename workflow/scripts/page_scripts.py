"""The scripts of others that pages use, written once beside the report."""

from pathlib import Path

import _log

from mammosim.io.atomic import replacing
from mammosim.study.report.scripts import SCRIPTS


def main(out: list[str]) -> None:
    for path in map(Path, out):
        with replacing(path) as temporary:
            Path(temporary).write_bytes(SCRIPTS[path.name]())


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(list(snakemake.output))
