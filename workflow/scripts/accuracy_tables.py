"""What accuracy costs: the table of all trials, orders, error budget, and the numbers of the page."""

import _log
import pandas as pd

from mammosim.io.atomic import replacing
from mammosim.io.tables import read_table, write_numbers, write_table
from mammosim.study.accuracy.error_budget import budget, numbers
from mammosim.study.accuracy.errors import accuracy, orders
from mammosim.study.accuracy.presets import choices, preset_text, presets


def main(rows: list[str], limits: dict, out: dict) -> None:
    table = accuracy(pd.concat([read_table(path) for path in rows], ignore_index=True))
    shares, made = budget(table), choices(table, limits)
    listed = presets(made, limits)
    write_table(table, out["table"])
    write_table(orders(table), out["orders"])
    write_table(shares, out["budget"])
    write_table(listed, out["presets"])
    write_numbers(numbers(table, shares, listed), out["numbers"])
    for (preset, choice), path in zip(made.items(), out["files"], strict=True):
        with replacing(path) as temporary:
            temporary.write_text(preset_text(preset, choice))


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.params.limits, dict(snakemake.output.items()))
