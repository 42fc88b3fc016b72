"""What a point answers: a row of values with their errors, by which moduli, and how it ended."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from mammosim.chain.graph import Chain, Inputs, upstream
from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.quantities import QUANTITIES, Quantity
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError, DamagedFile, MammosimError
from mammosim.study.campaigns.campaign import STRESS_FREE
from mammosim.study.campaigns.failures import ProgramFault

REJECTED, FAILED = "rejected", "failed"
FAULT = "fault of the program: "  # what the reason of a point begins with that is to be computed again
NAMED = 3  # points that a message names
Row = dict[str, Any]


class PointsFailed(MammosimError):
    """The program itself failed in points of a campaign, whose table has all the others."""

    @classmethod
    def of(cls, points: Sequence[str], *, table: str) -> "PointsFailed":
        """points: see faults."""
        more = f"; and {len(points) - NAMED} more" if len(points) > NAMED else ""
        return cls(
            f"the program failed in {'; '.join(points[:NAMED])}{more}. {table} has their reasons and all "
            "others; the same command computes them again; results/logs/campaigns_batch has their tracebacks"
        )


def answered(chain: Chain, read: Iterable[str]) -> Row:
    """The row of a point. read: the products that answers are taken from."""
    read = {*read}
    asked = {name: each for name, each in QUANTITIES.items() if {*each.products, *each.beside} <= read}
    try:
        row = row_of(*_answers(chain, asked))
    except DamagedFile:
        raise
    except MammosimError as error:
        row = row_of(None, None, *_outcome(error))
    return row | {"moduli_factor": moduli_factor(chain, read)}


def moduli_factor(chain: Chain, read: set[str]) -> float | None:
    """By what all moduli were multiplied: of what is pressed, of what hangs where nothing is pressed.

    None where there is no stress-free shape, or nothing is made of it.
    """
    # With all of mechanics, which points that are finished do not need.
    from mammosim.chain.unloaded import pressed_factor

    if STRESS_FREE not in read:
        return None
    pressed = any("press_setup" in upstream(STAGES, each) for each in read)
    try:
        if pressed:
            return pressed_factor(Inputs(chain, STAGES["press_setup"]))
        return float(chain[STRESS_FREE].moduli_factor)
    except MammosimError:
        return None


def _answers(
    chain: Chain, answered: Mapping[str, Quantity]
) -> tuple[dict[str, float | None], dict[str, float | None]]:
    """Every value, three of a place, and its standard error where it has one; None for no finite number."""
    values: dict[str, float | None] = {}
    errors: dict[str, float | None] = {}
    for name, quantity in answered.items():
        column = quantity.column or name
        found = np.atleast_1d(np.asarray(quantity.of(chain), float))
        values |= dict(zip(columns(column, len(found)), map(_finite, found)))
        if quantity.noise is not None:
            errors[column] = _finite(abs(found[0]) * quantity.noise(chain))
    return values, errors


def columns(column: str, size: int) -> tuple[str, ...]:
    """'nipple_x_mm', 'nipple_y_mm' and 'nipple_z_mm' of a place, else the name itself."""
    if size == 1:
        return (column,)
    name, _, unit = column.rpartition("_")
    return tuple(f"{name}_{axis}_{unit}" for axis in "xyz"[:size])


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def row_of(
    answers: Mapping[str, float | None] | None = None,
    errors: Mapping[str, float | None] | None = None,
    outcome: str = CONVERGED,
    reason: str = "",
) -> Row:
    """Answers and errors by column; moduli_factor; outcome, reason; seconds, and `took`: of each product."""
    none = ", ".join(name for name, value in (answers or {}).items() if value is None)
    why = reason or (f"no finite number: {none}" if none else "")
    return {
        "answers": dict(answers or {}), "errors": dict(errors or {}), "moduli_factor": None,
        "outcome": outcome, "reason": why, "seconds": 0.0, "took": {},
    }  # fmt: skip


def _outcome(error: MammosimError) -> tuple[str, str]:
    reason = " ".join(str(error).split())
    if isinstance(error, ConfigurationError):
        return REJECTED, reason
    return unsolved(error).split(":")[0], reason


def faulty(error: Exception) -> Row:
    """The row of a point in which the program itself failed."""
    kind = "" if isinstance(error, ProgramFault) else f"{type(error).__name__}: "
    return row_of(outcome=FAILED, reason=" ".join(f"{FAULT}{kind}{error}".split()))


def faults(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """The points in which the program itself failed, each with its settings and the reason."""
    return [
        f"point {row['point']} ({', '.join(f'{key} = {value}' for key, value in row['shown'].items())}): "
        f"{row['reason'].removeprefix(FAULT)}"
        for row in rows
        if row["reason"].startswith(FAULT)
    ]
