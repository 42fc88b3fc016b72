"""What the data of each volunteer do not allow, and why."""

import _log
import pandas as pd

from mammosim.io.tables import write_table

if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    write_table(
        pd.DataFrame(snakemake.params.rows, columns=["volunteer", "not_planned", "reason"]),
        snakemake.output[0],
    )
