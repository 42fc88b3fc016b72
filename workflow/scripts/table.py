"""One table of the study from the rows of its parts, with a reason for each part that is missing."""

import _stage
import pandas as pd

from mammosim.io.tables import HOLDING_DIGITS, read_rows, write_table


def main(rows: list[str], out: str) -> None:
    table = pd.concat([whole(read_rows(path)) for path in rows], ignore_index=True)
    reasons = [name for name in table if name == "outcome"]
    write_table(table[[*table.columns.drop(reasons), *reasons]], out, digits=HOLDING_DIGITS)


def whole(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with integers that stay whole beside rows without numbers."""
    integers = rows.select_dtypes("integer").columns
    return rows.astype(dict.fromkeys(integers, "Int64"))


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.rows, snakemake.output[0])
