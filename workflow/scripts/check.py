"""The verdict on every volunteer, a line each; it fails where the data of one cannot be used."""

import sys

import _log
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.io.tables import read_json, write_table
from mammosim.study.report.women import verdict


def main(verdicts: list[str], pages: list[str], out: str) -> None:
    found = [read_json(path) for path in verdicts]
    rows = [verdict(each, page) for each, page in zip(found, pages, strict=True)]
    sys.stdout.write("\n".join(rows) + "\n")
    if stopped := [each["volunteer"] for each in found if each["stops"]]:
        raise ConfigurationError(
            f"the data of {', '.join(stopped)} cannot be used ({len(stopped)} of {len(found)} volunteers); "
            "see the lines above and the pages that they name"
        )
    write_table(pd.DataFrame({"volunteer": [each["volunteer"] for each in found], "verdict": rows}), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(list(snakemake.input.verdicts), list(snakemake.input.pages), snakemake.output[0])
