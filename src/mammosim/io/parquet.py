"""Tables as Parquet, which other programs read with their types."""

from pathlib import Path
from typing import Any

import pandas as pd

from mammosim.io.atomic import replacing


def write_parquet(frame: pd.DataFrame, path: str | Path) -> None:
    """Write the columns without the index: text, whole numbers, true and false, and other numbers as such.

    A column of several kinds is text; what is missing is null.
    """
    from arro3.core import Array, Table
    from arro3.io import write_parquet as write

    columns: dict[str, Any] = {str(name): Array(*_as_arrow(column)) for name, column in frame.items()}
    with replacing(path) as temporary:
        write(Table.from_pydict(columns), temporary)


def _as_arrow(column: pd.Series) -> tuple[list[Any], Any]:
    """The values of a column, None where one is missing, and their type."""
    from arro3.core import DataType

    values = [None if pd.isna(value) else value for value in column.tolist()]
    kinds = {type(value) for value in values} - {type(None)}
    for kind, arrow in ((bool, DataType.bool()), (int, DataType.int64())):
        if kinds == {kind}:
            return values, arrow
    if kinds <= {int, float}:
        return [None if value is None else float(value) for value in values], DataType.float64()
    return [None if value is None else str(value) for value in values], DataType.utf8()
