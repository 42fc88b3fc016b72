"""What accuracy costs: the table of all trials, orders, error budget, and the numbers of the page."""

from pathlib import Path

import _log
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.io.tables import read_table, write_json, write_table
from mammosim.study.accuracy import accuracy, orders
from mammosim.study.accuracy_summary import numbers
from mammosim.study.error_budget import budget
from mammosim.study.preset_tables import preset_text, presets
from mammosim.study.presets import chosen


def main(rows: list[str], limits: dict, out: dict) -> None:
    table = accuracy(pd.concat([read_table(path) for path in rows], ignore_index=True))
    shares, made = budget(table), presets(table, limits)
    write_table(table, out["table"])
    write_table(orders(table), out["orders"])
    write_table(shares, out["budget"])
    write_table(made, out["presets"])
    write_json(numbers(table, shares, made), out["numbers"])
    for preset, path in zip(limits, out["files"]):
        Path(path).write_text(text_of(preset, table, limits[preset]))


def text_of(preset: str, table: pd.DataFrame, limits: dict[str, float]) -> str:
    """The file of a preset, or why there is none."""
    try:
        return preset_text(preset, chosen(table, limits))
    except ConfigurationError as refusal:
        return f"# Preset {preset} was refused: {refusal}\n"


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.params.limits, dict(snakemake.output.items()))
