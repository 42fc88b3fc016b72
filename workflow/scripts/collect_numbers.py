"""Every number of the study's tables by name, and the headlines that the report quotes."""

from contextlib import suppress
from pathlib import Path

import _log

from mammosim.core.errors import MissingResult
from mammosim.io.tables import read_rows, read_table, write_numbers
from mammosim.study.report.headlines import headlines
from mammosim.study.report.summary import numbers

# The columns that tell the rows of each table apart.
KEYS = {
    "registration": ("volunteer", "position", "step"),
    "registration_error": ("volunteer", "position"),
    "segmentation_overlap": ("volunteer", "position", "tissue"),
    "sweep": ("volunteer", "youngs_modulus_kpa"),
    "upright": ("volunteer", "skin_kpa"),
    "morph": ("volunteer", "level"),
    "stress_free": ("volunteer", "position", "method", "iteration"),
    "stress_free_attempts": ("volunteer", "position", "method", "moduli_factor"),
    "stress_free_error": ("volunteer", "method"),
    "unloading": ("volunteer", "youngs_modulus_kpa", "method"),
    "identification": ("volunteer", "side", "tissue"),
    "fit": ("volunteer",),
    "grid": ("volunteer", "breast_kpa", "skin_kpa"),
    "moduli": ("volunteer", "side", "tissue"),
    "validation": ("volunteer", "position", "quantity"),
    "propagation": ("volunteer", "side", "quantity"),
    "propagation_pressed": ("volunteer", "side", "rank"),
    "compression": ("volunteer", "side", "strategy", "moduli"),
    "compression_amounts": (
        *("volunteer", "side", "strategy", "moduli"),
        *("measure", "threshold", "tissue"),
    ),
    "conservation": ("volunteer", "side", "strategy", "moduli", "quantity", "tissue", "step"),
    "dose": ("volunteer", "side", "strategy", "moduli"),
    "image": ("volunteer", "side", "strategy", "moduli"),
    "answer": ("volunteer", "side"),
}
# Two runs give the same numbers; how long they took is in the report's last section.
TIMES = ["seconds", "forward_solves"]


def main(paths: list[str], out: str) -> None:
    tables = {}
    for path in paths:
        with suppress(MissingResult):  # a number of a table that is missing is a dash in the report
            tables[Path(path).stem] = read_table(path, may_be_empty=True)
    # Strategies that found no equilibrium are counted.
    rows = {Path(path).stem: read_rows(path) for path in paths if Path(path).stem == "compression"}
    quoted = {name: tables[name].drop(columns=TIMES, errors="ignore") for name in KEYS if name in tables}
    write_numbers(headlines(tables | rows) | numbers(quoted, KEYS), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.tables, snakemake.output[0])
