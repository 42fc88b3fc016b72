"""One hard case: what is expected and what happens, a row of results/study/hard_cases.csv."""

import _log
import pandas as pd

from mammosim.io.tables import write_table
from mammosim.study.hard_cases.cases import HardCase, row


def main(name: str, values: dict, out: str) -> None:
    write_table(pd.DataFrame([row(HardCase.of(name, values))]), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.wildcards.case, snakemake.params["values"], snakemake.output[0])
