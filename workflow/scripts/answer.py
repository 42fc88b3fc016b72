"""How far compression of each breast can be reduced, what strategies cost, and what these data cannot say."""

from itertools import product
from pathlib import Path

import _log

from mammosim.core.settings import read
from mammosim.io.tables import HOLDING_DIGITS, read_commented, read_rows, write_table
from mammosim.study.accuracy.presets import errors_at
from mammosim.study.report.answer import answer_table, answers
from mammosim.study.report.answer_limits import Known, limits_table, why_not_pressed
from mammosim.study.report.answer_words import sentence
from mammosim.study.report.pressed_breast import breasts
from mammosim.study.report.strategy_costs import (
    ASKED,
    LossLimits,
    Numerical,
    kept_in_changes,
    strategy_costs,
)

SIDES = ("left", "right")


def main(files: dict, settings: dict, out: dict) -> None:
    tables = {Path(path).stem: read_rows(path) for path in files["tables"]}
    limits = read(LossLimits, settings["loss_percent"], "answer.loss_percent")
    known = read(Known, settings["known"], "known")
    measured = kept_in_changes(read_commented(files["measured"]))
    pressed = breasts(tables)
    errors = Numerical.of(errors_at(measured, {"xray": settings["xray"]}, ASKED))
    costs = strategy_costs(pressed, numerical=errors, limits=limits)
    asked = list(product(settings["volunteers"], SIDES))
    found = answers(costs, pressed, limits, asked=asked, why_not=why_not_pressed(asked, known, tables))
    # A side that the settings do not ask for is among the limits only.
    words = [sentence(each, costs, limits) if each.side in known.sides else "" for each in found]
    write_table(answer_table(found).assign(sentence=words), out["answer"], digits=HOLDING_DIGITS)
    write_table(costs, out["strategies"], digits=HOLDING_DIGITS)
    write_table(limits_table(found, costs, tables, known), out["limits"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {"tables": snakemake.input.tables, "measured": snakemake.input.measured},
        {name: value for name, value in snakemake.params.items() if name != "library"},
        dict(snakemake.output.items()),
    )
