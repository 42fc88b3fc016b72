"""What a study asked for and did not get: each reason once, with the tables and figures that lack it."""

import textwrap
from collections.abc import Iterator, Mapping

import pandas as pd

from mammosim.io.missing import missing_rows, reason_of

COLUMNS = ("reason", "tables", "figures")
REFUSED = "refused: "
COMPRESSION = "compression"
NAMED, WIDTH = 8, 200  # reasons on the terminal, and their letters
BREAST = ["volunteer", "side", "strategy", "moduli"]


def missing_results(tables: Mapping[str, pd.DataFrame], figures: Mapping[str, str | None]) -> pd.DataFrame:
    """A row per reason: COLUMNS, of which the last two are names joined by commas.

    tables: name -> rows, with those in the place of missing results; figures: name -> why it is missing, None
    where it is there. A compression that found no equilibrium is missing, too.
    """
    found: dict[str, tuple[list[str], list[str]]] = {}
    for name, table in tables.items():
        for reason in _reasons(name, table):
            found.setdefault(reason, ([], []))[0].append(name)
    for name, why in figures.items():
        if why is not None:
            found.setdefault(why, ([], []))[1].append(name)
    rows = [(reason, _joined(inside), _joined(drawn)) for reason, (inside, drawn) in found.items()]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _reasons(name: str, table: pd.DataFrame) -> Iterator[str]:
    """Why rows of a table are missing."""
    for outcome in table.outcome[missing_rows(table)] if "outcome" in table else ():
        yield reason_of(outcome)
    if name == COMPRESSION and "outcome" in table:
        refused = table[table.outcome.astype(str).str.startswith(REFUSED)]
        for row in refused.to_dict("records"):
            names = " ".join(str(row[key]) for key in BREAST)
            yield f"compress {names}: {row['outcome'].removeprefix(REFUSED)}"


def _joined(names: list[str]) -> str:
    return ", ".join(dict.fromkeys(names))


def told_briefly(missing: pd.DataFrame) -> str:
    """What a terminal ends with: the first reasons, a line each; nothing where nothing is missing."""
    if missing.empty:
        return ""
    lines = [f"  {textwrap.shorten(reason, WIDTH)}" for reason in missing.reason[:NAMED]]
    more = [f"  and {len(missing) - NAMED} more"] if len(missing) > NAMED else []
    last = "Everything else is there; the first page of the report names what follows from these."
    return "\n".join([f"{_count(missing)} could not be had:", *lines, *more, last])


def told(missing: pd.DataFrame) -> str:
    """The sentence by which a report begins."""
    if missing.empty:
        return "Every result that was asked for is there."
    return (
        f"**{_count(missing)} could not be had.** The table says why, and which tables and figures lack it; "
        "what follows from it is missing there for the same reason. Everything else is complete."
    )


def _count(missing: pd.DataFrame) -> str:
    return "One result" if len(missing) == 1 else f"{len(missing)} results"
