"""Tables as Parquet, which other programs read with their types."""

from pathlib import Path
from typing import Any

import pandas as pd

from mammosim.io.atomic import replacing

WHOLE = 2**63


def write_parquet(frame: pd.DataFrame, path: str | Path) -> None:
    """Write the columns without the index: text, whole numbers, true and false, and other numbers as such.

    A column of several kinds is text, one with whole numbers that 64 bits do not hold is of other numbers;
    what is missing is null.
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
    if kinds == {bool}:
        return values, DataType.bool()
    if kinds == {int} and all(value is None or -WHOLE <= value < WHOLE for value in values):
        return values, DataType.int64()
    if kinds <= {int, float}:
        return [None if value is None else float(value) for value in values], DataType.float64()
    return [None if value is None else str(value) for value in values], DataType.utf8()
