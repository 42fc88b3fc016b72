"""What a study asked for and did not get: each reason once, with the tables and figures that lack it."""

from collections.abc import Mapping

import pandas as pd

from mammosim.io.missing import missing_rows, reason_of
from mammosim.study.jobs.last_words import count_of

COLUMNS = ("reason", "tables", "figures")


def missing_results(tables: Mapping[str, pd.DataFrame], figures: Mapping[str, str | None]) -> pd.DataFrame:
    """A row per reason: COLUMNS, of which the last two are names joined by commas.

    tables: name -> rows, with those in the place of missing results; figures: name -> why it is missing, None
    where it is there.
    """
    found: dict[str, tuple[list[str], list[str]]] = {}
    for name, table in tables.items():
        for reason in map(reason_of, table.outcome[missing_rows(table)] if "outcome" in table else ()):
            found.setdefault(reason, ([], []))[0].append(name)
    for name, why in figures.items():
        if why is not None:
            found.setdefault(why, ([], []))[1].append(name)
    rows = [(reason, _joined(inside), _joined(drawn)) for reason, (inside, drawn) in found.items()]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _joined(names: list[str]) -> str:
    return ", ".join(dict.fromkeys(names))


def completeness_sentence(missing: pd.DataFrame) -> str:
    """The sentence by which a report begins."""
    if missing.empty:
        return "Every result that was asked for is there."
    return (
        f"**{count_of(missing.reason)} could not be computed.** The table gives the reasons, and the tables "
        "and figures that lack these results and what depends on them. Everything else is complete."
    )
