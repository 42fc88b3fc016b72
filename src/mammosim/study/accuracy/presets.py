"""The cheapest settings that meet asked tolerances, chosen exactly from measured errors and times.

One value v of each knob k, x_kv in {0, 1}:

    minimise  sum_kv x_kv (ln f_kv + TIE sum_q r_kvq),   f_kv = (T - t_k + t_kv) / T
    with      sum_v x_kv = 1 for each k,   sum_kv x_kv r_kvq <= 1 for each quantity q,
              r_kvq = e_kvq^2 / tolerance_q^2

T is the time of the whole chain at today's settings, t_k that of what knob k touches at today's value. The
estimated time is T prod f: where two knobs shorten the same product, their parts multiply. TIE lets accuracy
decide between times that are as good as equal.
"""

# ASSUME: errors add as squares, and the factors of the time multiply.
# ASSUME: what asked quantities need of a knob is nested: the quantity that takes longest counts.

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import Bounds, LinearConstraint, milp

from mammosim.chain.graph import nested, pruned
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.trial import OK

CHAIN, IMAGES = "chain", "images"  # a knob, a stage
LEAST_FACTOR = 1e-3  # of the time of the chain that one knob may leave
TIE = 1e-3  # what the time may be longer by, relative, for each quantity, where that lowers the error


@dataclass(frozen=True)
class Choice:
    """settings: dotted name -> value; errors: quantity -> of all knobs together; seconds: of the chain.

    table: knob, value, quantity, error that it leaves, a row per knob and asked quantity; names: knob -> the
    dotted names that it sets.
    """

    settings: Mapping[str, Any]
    errors: Mapping[str, float]
    seconds: float
    table: pd.DataFrame
    names: Mapping[str, tuple[str, ...]]


def chosen(measured: pd.DataFrame, wanted: Mapping[str, float]) -> Choice:
    """The cheapest settings whose errors stay within `wanted`, quantity -> tolerance in the unit of its name.

    measured: study.accuracy.errors.accuracy. Knobs that none of the quantities depends on stay as they are.
    Raises ConfigurationError for an unknown quantity, for a tolerance that is not positive, and, with the
    least error that can be had, for one that cannot be met.
    """
    _check(measured, wanted)
    options = _options(measured, list(wanted))
    r = np.array([options[f"error_{q}"] ** 2 / wanted[q] ** 2 for q in wanted])
    _check_least(options, r, wanted)
    one_each = np.array([(options.knob == knob).to_numpy(float) for knob in options.knob.unique()])
    constraints = [LinearConstraint(one_each, 1, 1), LinearConstraint(r, -np.inf, 1)]
    found = milp(
        np.log(options.factor.to_numpy(float)) + TIE * r.sum(axis=0),
        constraints=constraints,
        integrality=np.ones(len(options)),
        bounds=Bounds(0, 1),
        options={"mip_rel_gap": 0},
    )
    if found.x is None:
        raise ConfigurationError(
            f"no settings meet {dict(wanted)} together, though each can be met alone; allow one of them more"
        )
    return _choice(options[found.x > 0.5], list(wanted), _seconds(measured, list(wanted)))


def errors_at(measured: pd.DataFrame, settings: Mapping[str, Any], asked: Iterable[str]) -> dict[str, float]:
    """The error of each asked quantity with these settings (nested), by all knobs that were measured for it.

    NaN for one that was not, or where a knob has a value that was not tried. Images count as they are today.
    """
    return {quantity: _error_at(measured[measured["quantity"] == quantity], settings) for quantity in asked}


def _error_at(rows: pd.DataFrame, settings: Mapping[str, Any]) -> float:
    errors2 = []
    for _, values in rows[rows.knob != CHAIN].groupby("knob", sort=False):
        of_images = values.stage == IMAGES
        chosen = [bool(today) if image else _are(settings, text)
                  for image, today, text in zip(of_images, values.today, values.settings)]  # fmt: skip
        errors2.append(float(values.error[chosen].max()) ** 2)
    return float(np.sqrt(sum(errors2))) if errors2 else np.nan


def _are(settings: Mapping[str, Any], text: str) -> bool:
    """Whether the settings have the values of a JSON text."""
    given = json.loads(text)
    return pruned(settings, given) == nested(given)


def as_imaged(measured: pd.DataFrame) -> pd.DataFrame:
    """Only the rows among which one can choose where the images have been labelled already."""
    return measured[(measured.stage != IMAGES) | measured.today]


def _check(measured: pd.DataFrame, wanted: Mapping[str, float]) -> None:
    known = list(dict.fromkeys(measured["quantity"][measured.knob != CHAIN]))
    if not wanted:
        raise ConfigurationError(f"no accuracy is asked; name some of: {', '.join(known)}")
    for quantity, tolerance in wanted.items():
        if quantity not in known:
            raise ConfigurationError(f"no measured error of {quantity!r}; choose among: {', '.join(known)}")
        if not tolerance > 0:
            raise ConfigurationError(f"{quantity}: {tolerance:g} is no tolerance; give one more than 0")


def _options(measured: pd.DataFrame, wanted: list[str]) -> pd.DataFrame:
    """Per knob and usable value: settings, factor, and error_ of each quantity, 0 where it has none."""
    rows = measured[measured["quantity"].isin(wanted) & (measured.knob != CHAIN)]
    T = _seconds(measured, wanted)
    found = []
    for knob, of_knob in rows.groupby("knob", sort=False):
        usable = of_knob.groupby("value", sort=False).filter(
            lambda value: bool((value.outcome == OK).all() and value.error.notna().all())
        )
        t_today = float(of_knob.seconds[of_knob.today].max())
        for name, value in usable.groupby("value", sort=False):
            errors = dict(zip(value["quantity"], value.error))
            factor = max((T - t_today + float(value.seconds.max())) / T, LEAST_FACTOR)
            line = {"knob": knob, "value": name, "settings": value.settings.iloc[0], "factor": factor}
            found.append(line | {f"error_{q}": errors.get(q, 0.0) for q in wanted})
        if np.isfinite(of_knob["size"].iloc[0]):
            _never_luckier(found[len(found) - usable.value.nunique() :], wanted)
        if usable.empty:
            raise ConfigurationError(f"every value of the knob {knob} was refused; measure it again")
    return pd.DataFrame(found)


def _never_luckier(lines: list[dict[str, Any]], wanted: list[str]) -> None:
    """Give each value of one knob, from draft to reference, at least the errors of the finer ones."""
    # ASSUME: a coarser value that came nearer than a finer one did so by chance.
    for coarser, finer in zip(lines[-2::-1], lines[:0:-1]):
        for name in (f"error_{q}" for q in wanted):
            coarser[name] = max(coarser[name], finer[name])


def _seconds(measured: pd.DataFrame, wanted: list[str]) -> float:
    """T. Raises ConfigurationError where the measured times lack it."""
    rows = measured[(measured.knob == CHAIN) & measured["quantity"].isin(wanted)]
    if missing := sorted(set(wanted) - set(rows["quantity"])):
        raise ConfigurationError(
            f"the time of the whole chain for {missing[0]} is not among what was measured"
        )
    return float(rows.seconds.max())


def _check_least(options: pd.DataFrame, r: np.ndarray, wanted: Mapping[str, float]) -> None:
    """Refuse a tolerance below what the most accurate value of every knob leaves."""
    for quantity, row in zip(wanted, r):
        least = wanted[quantity] * np.sqrt(pd.Series(row).groupby(options.knob.to_numpy()).min().sum())
        if least > wanted[quantity]:
            raise ConfigurationError(
                f"{quantity}: {wanted[quantity]:g} is less than the least error that can be had, "
                f"{least:.3g}; ask for more, or add a finer value to a knob of config/accuracy/knobs.yaml"
            )


def _choice(taken: pd.DataFrame, wanted: list[str], T: float) -> Choice:
    settings: dict[str, Any] = {}
    for text in taken.settings:
        settings |= json.loads(text)
    errors = {q: float(np.sqrt((taken[f"error_{q}"] ** 2).sum())) for q in wanted}
    table = taken.melt(["knob", "value"], [f"error_{q}" for q in wanted], "quantity", "error")
    table["quantity"] = table["quantity"].str.removeprefix("error_")
    names = {knob: tuple(json.loads(text)) for knob, text in zip(taken.knob, taken.settings)}
    return Choice(settings, errors, float(T * taken.factor.prod()), table, names)
