"""Presets: the cheapest settings that meet asked tolerances, chosen exactly from measured errors and times.

One value v of each parameter k, x_kv in {0, 1}:

    minimise  sum_kv x_kv (ln f_kv + TIE sum_q r_kvq),   f_kv = (T - t_k + t_kv) / T
    with      sum_v x_kv = 1 for each k,   sum_kv x_kv r_kvq <= 1 for each quantity q,
              r_kvq = e_kvq^2 / tolerance_q^2

T is the time of the whole chain at today's settings, t_k that of what parameter k touches at today's value.
The estimated time is T prod f: where two parameters shorten the same product, their parts multiply. TIE lets
accuracy decide between times that are as good as equal.
"""

# ASSUME: errors add as squares, and the factors of the time multiply.
# ASSUME: what asked quantities need of a parameter is nested: the quantity that takes longest counts.

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy import format_float_scientific
from scipy.optimize import Bounds, LinearConstraint, milp

from mammosim.chain.graph import nested
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.parameters import Nested, Overrides
from mammosim.study.accuracy.trial import CHAIN, CONVERGED, outcome_of

IMAGES = "images"  # a stage
COLUMNS = ["preset", "parameter", "value", "quantity", "error", "tolerance", "seconds", "outcome"]
Limits = Mapping[str, Mapping[str, float]]  # preset -> quantity -> tolerance
LEAST_FACTOR = 1e-3  # of the time of the chain that one parameter may leave
TIE = 1e-3  # what the time may be longer by, relative, for each quantity, where that lowers the error


@dataclass(frozen=True)
class Choice:
    """overrides: parameter -> what it sets; errors: quantity -> of all together; seconds: of the chain.

    table: parameter, value, quantity, error that it leaves, a row per parameter and asked quantity.
    """

    overrides: Mapping[str, Overrides]
    errors: Mapping[str, float]
    seconds: float
    table: pd.DataFrame

    @property
    def settings(self) -> dict[str, object]:
        """Dotted name -> value, of all parameters."""
        return {name: value for each in self.overrides.values() for name, value in each.by_name.items()}


def chosen(measured: pd.DataFrame, wanted: Mapping[str, float]) -> Choice:
    """The cheapest settings whose errors stay within `wanted`, quantity -> tolerance in the unit of its name.

    measured: study.accuracy.errors.accuracy. What none of the quantities depends on stays as it is.
    Raises ConfigurationError for an unknown quantity, for a tolerance that is not positive, and, with the
    least error that can be had, for one that cannot be met.
    """
    _check(measured, wanted)
    options = _options(measured, list(wanted))
    r = np.array([options[f"error_{q}"] ** 2 / wanted[q] ** 2 for q in wanted])
    _check_least(options, r, wanted)
    one_each = np.array([(options.parameter == name).to_numpy(float) for name in options.parameter.unique()])
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


def errors_at(measured: pd.DataFrame, settings: Nested, asked: Iterable[str]) -> dict[str, float]:
    """The error of each asked quantity with these nested settings, by all parameters measured for it.

    NaN for one that was not, or where a parameter has a value that was not tried. Images count as today's.
    """
    return {quantity: _error_at(measured[measured["quantity"] == quantity], settings) for quantity in asked}


def _error_at(rows: pd.DataFrame, settings: Nested) -> float:
    errors2 = []
    for _, values in rows[rows.parameter != CHAIN].groupby("parameter", sort=False):
        of_images = values.stage == IMAGES
        chosen = [bool(today) if image else Overrides(text).hold_in(settings)
                  for image, today, text in zip(of_images, values.today, values.settings)]  # fmt: skip
        errors2.append(float(values.error[chosen].max()) ** 2)
    return float(np.sqrt(sum(errors2))) if errors2 else np.nan


def pace_at(measured: pd.DataFrame, settings: Nested, asked: Iterable[str]) -> float:
    """What the chain takes with these nested settings, over what it takes with today's: prod f, the slowest.

    A parameter that was not measured with its value, or at all, counts as today's; a quantity that was not
    measured does not count.
    """
    known = set(measured["quantity"])
    each = (measured[measured["quantity"] == quantity] for quantity in asked if quantity in known)
    return max((_pace_at(rows, settings) for rows in each), default=1.0)


def _pace_at(rows: pd.DataFrame, settings: Nested) -> float:
    today = rows[rows.today].set_index("parameter").seconds
    pace = 1.0
    for name, values in rows[(rows.parameter != CHAIN) & (rows.stage != IMAGES)].groupby(
        "parameter", sort=False
    ):
        here = values.seconds[[Overrides(text).hold_in(settings) for text in values.settings]]
        if len(here) and name in today:
            pace *= max(LEAST_FACTOR, (today[CHAIN] - today[name] + here.iloc[0]) / today[CHAIN])
    return pace


def as_imaged(measured: pd.DataFrame) -> pd.DataFrame:
    """Only the rows among which one can choose where the images have been labelled already."""
    return measured[(measured.stage != IMAGES) | measured.today]


def _check(measured: pd.DataFrame, wanted: Mapping[str, float]) -> None:
    known = list(dict.fromkeys(measured["quantity"][measured.parameter != CHAIN]))
    if not wanted:
        raise ConfigurationError(f"no accuracy is asked; name some of: {', '.join(known)}")
    for quantity, tolerance in wanted.items():
        if quantity not in known:
            raise ConfigurationError(f"no measured error of {quantity!r}; choose among: {', '.join(known)}")
        if not tolerance > 0:
            raise ConfigurationError(f"{quantity}: {tolerance:g} is no tolerance; give one more than 0")


def _options(measured: pd.DataFrame, wanted: list[str]) -> pd.DataFrame:
    """Per parameter and usable value: settings, factor, and error_ of each quantity, 0 where it has none."""
    rows = measured[measured["quantity"].isin(wanted) & (measured.parameter != CHAIN)]
    T = _seconds(measured, wanted)
    found = []
    for parameter, of_it in rows.groupby("parameter", sort=False):
        usable = of_it.groupby("value", sort=False).filter(
            lambda value: bool((value.outcome == CONVERGED).all() and value.error.notna().all())
        )
        if usable.empty:
            raise ConfigurationError(f"no value of the parameter {parameter} has an answer; measure it again")
        t_today = float(of_it.seconds[of_it.today].max())
        for name, value in usable.groupby("value", sort=False):
            errors = dict(zip(value["quantity"], value.error))
            factor = max((T - t_today + float(value.seconds.max())) / T, LEAST_FACTOR)
            line = {"parameter": parameter, "value": name, "settings": value.settings.iloc[0]}
            found.append(line | {"factor": factor} | {f"error_{q}": errors.get(q, 0.0) for q in wanted})
        if np.isfinite(of_it["size"].iloc[0]):
            _never_luckier(found[len(found) - usable.value.nunique() :], wanted)
    return pd.DataFrame(found)


def _never_luckier(lines: list[dict[str, Any]], wanted: list[str]) -> None:
    """Give each value of one parameter, from draft to reference, at least the errors of the finer ones."""
    # ASSUME: a coarser value that came nearer than a finer one did so by luck.
    for coarser, finer in zip(lines[-2::-1], lines[:0:-1]):
        for name in (f"error_{q}" for q in wanted):
            coarser[name] = max(coarser[name], finer[name])


def _seconds(measured: pd.DataFrame, wanted: list[str]) -> float:
    """T. Raises ConfigurationError where the measured times lack it."""
    rows = measured[(measured.parameter == CHAIN) & measured["quantity"].isin(wanted)]
    if missing := sorted(set(wanted) - set(rows["quantity"])):
        raise ConfigurationError(
            f"the time of the whole chain for {missing[0]} is not among what was measured"
        )
    return float(rows.seconds.max())


def _check_least(options: pd.DataFrame, r: np.ndarray, wanted: Mapping[str, float]) -> None:
    """Reject a tolerance below what the most accurate value of every parameter leaves."""
    for quantity, row in zip(wanted, r):
        least = wanted[quantity] * np.sqrt(pd.Series(row).groupby(options.parameter.to_numpy()).min().sum())
        if least > wanted[quantity]:
            raise ConfigurationError(
                f"{quantity}: {wanted[quantity]:g} is less than the least error that can be had, "
                f"{least:.3g}; ask for more, or add a finer value to config/accuracy/parameters.yaml"
            )


def _choice(taken: pd.DataFrame, wanted: list[str], T: float) -> Choice:
    overrides = {parameter: Overrides(text) for parameter, text in zip(taken.parameter, taken.settings)}
    errors = {q: float(np.sqrt((taken[f"error_{q}"] ** 2).sum())) for q in wanted}
    table = taken.melt(["parameter", "value"], [f"error_{q}" for q in wanted], "quantity", "error")
    table["quantity"] = table["quantity"].str.removeprefix("error_")
    return Choice(overrides, errors, float(T * taken.factor.prod()), table)


def choices(measured: pd.DataFrame, limits: Limits) -> dict[str, Choice | ConfigurationError]:
    """What each preset is, or why its limits cannot be met."""
    found: dict[str, Choice | ConfigurationError] = {}
    for preset, wanted in limits.items():
        try:
            found[preset] = chosen(measured, wanted)
        except ConfigurationError as error:
            found[preset] = error
    return found


def presets(made: Mapping[str, Choice | ConfigurationError], limits: Limits) -> pd.DataFrame:
    """COLUMNS: per preset and quantity a row for the chain, then one per parameter; seconds of the chain.

    A preset whose limits cannot be met is a row that says why.
    """
    found = []
    for preset, choice in made.items():
        if isinstance(choice, Choice):
            found.append(_rows(preset, choice, limits[preset]))
        else:
            why = {"preset": preset, "parameter": CHAIN, "outcome": outcome_of(choice)}
            found.append(pd.DataFrame([why]))
    return pd.concat(found).reindex(columns=COLUMNS) if found else pd.DataFrame(columns=COLUMNS)


def _rows(preset: str, choice: Choice, wanted: Mapping[str, float]) -> pd.DataFrame:
    whole = [
        {"parameter": CHAIN, "quantity": q, "error": e, "tolerance": wanted[q], "seconds": choice.seconds}
        for q, e in choice.errors.items()
    ]
    return pd.concat([pd.DataFrame(whole), choice.table]).assign(preset=preset, outcome=CONVERGED)


def preset_text(preset: str, choice: Choice | ConfigurationError) -> str:
    """A choice as a file of overrides of the configuration, each setting with the errors that it leaves.

    Of limits that cannot be met a comment says why.
    """
    if not isinstance(choice, Choice):
        return f"# Preset {preset} was rejected: {choice}\n"
    totals = ", ".join(f"{q} {e:.2g}" for q, e in choice.errors.items())
    head = [f"# Preset {preset}: {totals}; about {choice.seconds:.0f} s of one processor for one breast."]
    return "\n".join([*head, *_lines(nested(choice.settings), "", _comments(choice))]) + "\n"


def _comments(choice: Choice) -> dict[str, str]:
    """Dotted name -> the errors of the parameter that set it."""
    found: dict[str, str] = {}
    for parameter, overrides in choice.overrides.items():
        rows = choice.table[(choice.table.parameter == parameter) & (choice.table.error > 0)]
        each = ", ".join(f"{q} {e:.2g}" for q, e in zip(rows["quantity"], rows.error))
        found |= dict.fromkeys(overrides.by_name, each or "the reference")
    return found


def _lines(tree: Nested, above: str, comments: Mapping[str, str]) -> list[str]:
    """Lines of YAML; a value that is a mapping, a list or a number stands on one line."""
    found = []
    for key, value in tree.items():
        name, depth = f"{above}{key}", 2 * above.count(".")
        if isinstance(value, Mapping) and name not in comments:
            found += [f"{' ' * depth}{key}:", *_lines(value, f"{name}.", comments)]
        else:
            found.append(f"{' ' * depth}{key}: {_flow(value)} # {comments[name]}")
    return found


def _flow(value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return format_float_scientific(value) if isinstance(value, float) and 0 < value < 1e-3 else str(value)
