"""Reject a configuration that cannot be meant, before anything is computed, and say what to write instead."""

import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from functools import reduce
from operator import getitem
from typing import Any

import numpy as np
from jsonschema import Draft202012Validator, ValidationError
from jsonschema.validators import extend

from mammosim.chain.advice import Place, advice, number_of, shown
from mammosim.chain.relations import Relation, unmet
from mammosim.core.errors import ConfigurationError
from mammosim.core.positions import GRAVITY, gravity_vector
from mammosim.io.label_codes import is_preset, presets

# Angle between the stated gravity and +y (posterior), degrees: what each position can mean.
ANGLE_TO_POSTERIOR_DEG = {
    "prone": (150, 180),
    "supine": (0, 20),
    "supine_tilted": (20, 80),
    "upright": (60, 120),
}


LARGEST = sys.float_info.max  # what is more is infinite, or a whole number that no float can hold


def _is_integer(_: Any, value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_number(_: Any, value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_finite(checker: Any, value: Any) -> bool:
    return _is_number(checker, value) and abs(value) <= LARGEST


# JSON takes 40.0 for an integer, and knows no NaN, which passes every limit.
_TYPES = Draft202012Validator.TYPE_CHECKER.redefine_many({"integer": _is_integer, "number": _is_finite})
_FINITE = extend(Draft202012Validator, type_checker=_TYPES)
_ANY = extend(Draft202012Validator, type_checker=_TYPES.redefine("number", _is_number))


def check_settings(
    settings: Any,
    schema: Mapping[str, Any],
    *,
    files: Iterable[str] | Mapping[str, Any],
    relations: Sequence[Relation] = (),
    known: Mapping[str, Collection[str]] | None = None,
    finite: bool = True,
) -> None:
    """Raise ConfigurationError with every unknown key, value outside its limits, and contradiction.

    settings: nested values as read. Text that YAML 1.2 reads as a number, as 2e-1, becomes it in place where
    the schema wants a number. schema: JSON schema (2020-12) with a description of each key; files: where the
    values came from, or file -> its values, later over earlier, so that each fault names its own; relations:
    between keys, and known: what they call names that stand in no setting; finite: whether NaN and infinity
    are rejected. One line per fault, `file: key = value: what it must be`.
    """
    errors = read_numbers(settings, schema, finite=finite)
    faults: dict[Place, str] = {}  # of one place the first: its kind before its limits
    for error in sorted(errors, key=lambda e: (list(map(str, e.absolute_path)), e.validator != "type")):
        for place, words in advice(error):
            faults.setdefault(place, words)
    lines = [f"{_giver(files, [place])}: {words}" for place, words in faults.items()]
    for places, words in unmet(settings, relations, known or {}):
        if not any(_related(place, fault) for place in places for fault in faults):
            lines.append(f"{_giver(files, places)}: {words}")
    if lines:
        raise ConfigurationError("\n".join(lines))


def read_numbers(settings: Any, schema: Mapping[str, Any], *, finite: bool = True) -> list[ValidationError]:
    """What the schema finds after text that is a number, as 2e-1, has become it in place."""
    validator = (_FINITE if finite else _ANY)(schema)
    errors = list(_errors(validator, settings))
    became = [_become_number(settings, error) for error in errors]
    return list(_errors(validator, settings)) if any(became) else errors


def _errors(validator: Any, settings: Any) -> Iterator[ValidationError]:
    """The errors of the schema; of several possible kinds, those of the one that is meant."""
    for error in validator.iter_errors(settings):
        yield from _meant(error)


def _meant(error: ValidationError) -> Iterator[ValidationError]:
    """The errors of the only branch of `oneOf` whose kind fits, else the error itself."""
    branches: dict[Any, list[ValidationError]] = {}
    for each in error.context or ():
        branches.setdefault(each.relative_schema_path[0], []).append(each)
    fitting = [
        found
        for found in branches.values()
        if not any(each.validator in ("type", "const", "enum") and not each.relative_path for each in found)
    ]
    if error.validator in ("oneOf", "anyOf") and len(fitting) == 1:
        for each in fitting[0]:
            yield from _meant(each)
    else:
        yield error


def _become_number(settings: Any, error: ValidationError) -> bool:
    """Whether a value of the wrong kind was the number that is wanted, and now stands in its place."""
    if (
        error.validator != "type"
        or error.validator_value not in ("number", "integer")
        or not error.absolute_path
    ):
        return False
    value = number_of(error.instance) if isinstance(error.instance, str) else error.instance
    if error.validator_value == "integer" and isinstance(value, float) and value.is_integer():
        value = int(value)
    if not isinstance(value, (int, float)) or isinstance(value, bool) or value is error.instance:
        return False
    *place, last = error.absolute_path
    reduce(getitem, place, settings)[last] = value
    return True


def _giver(files: Iterable[str] | Mapping[str, Any], places: Sequence[Place]) -> str:
    """The file that gave one of these places last; of what is nowhere, the file that gave its group."""
    names = list(files)
    if isinstance(files, Mapping):
        for cut in range(max(map(len, places)) + 1):
            held = [place[: len(place) - cut] for place in places if len(place) >= cut]
            for name in reversed(names):
                if any(_has(files[name], place) for place in held):
                    return name
    return ", ".join(names)


def _has(values: Any, place: Place) -> bool:
    try:
        reduce(getitem, place, values)
    except (KeyError, IndexError, TypeError):
        return False
    return True


def _related(one: Place, other: Place) -> bool:
    """Whether one place lies in the other."""
    common = min(len(one), len(other))
    return one[:common] == other[:common]


Row = Mapping[str, str]
# Columns of the table of volunteers, and those without which no row can be meant.
COLUMNS = (
    *("volunteer", "position", "images", "labels", "codes", "strokes", "fiducials", "gravity"),
    *("series", "gaps"),
)
NEEDED = ("volunteer", "position", "gravity")
LIKE = 0.65  # a name that is as near as this to a column's is a slip of it
GAPS = ("", "resample")  # what may be done to the gaps of unevenly spaced slices


def check_columns(rows: Sequence[Row], *, file: str) -> None:
    """Raise ConfigurationError when a column that is needed is not there, or one is named almost rightly."""
    found = list(rows[0]) if rows else list(NEEDED)
    for name in found:
        near = [] if name in COLUMNS else get_close_matches(name.strip().lower(), COLUMNS, n=1, cutoff=LIKE)
        if near and near[0] not in found:
            raise ConfigurationError(f"{file} has a column {name!r}; did you mean {near[0]!r}?")
    if absent := [name for name in NEEDED if name not in found]:
        raise ConfigurationError(
            f"{file} has no column {', '.join(absent)}; its first line names the columns, with tabs between "
            f"them, and reads {shown(' '.join(found))}"
        )


def check_volunteers(
    rows: Sequence[Row],
    *,
    file: str,
    there: Callable[[str], bool] = lambda path: True,
    digital: Collection[str] = (),
) -> None:
    """Raise ConfigurationError unless each row names a known position that agrees with its gravity.

    rows: of COLUMNS, gravity as 'x y z' in the scanner frame LPS, series as `io.dicom.read_series` has it.
    Each position stands once, and has labels or images of its own. there: whether a path that
    is named is there, or will be; digital: names of digital volunteers, whose scans are in results/raw/NAME.
    """
    positions: dict[str, list[str]] = {}
    for row in rows:
        positions.setdefault(row["volunteer"], []).append(row["position"])
    if twice := [
        f"{v} {p}" for v, found in positions.items() for p in sorted({p for p in found if found.count(p) > 1})
    ]:
        raise ConfigurationError(
            f"{file}: {', '.join(twice)} stand twice; give each position of a volunteer one row"
        )
    faults = [fault for row in rows for fault in _faults(row, file, there)]
    if faults:  # all at once: what is wrong with one volunteer hides nothing of another
        raise ConfigurationError("\n".join(faults))
    _check_own(rows, file)
    for volunteer in positions:
        scans = [row.get("images") or "" for row in rows if row["volunteer"] == volunteer]
        if volunteer in digital and not all(scan.startswith(f"results/raw/{volunteer}/") for scan in scans):
            raise ConfigurationError(
                f"{file}: {volunteer!r} is the name of a digital volunteer, whose scans are in results/raw/"
                f"{volunteer}; give another name"
            )
        labelled = {row["position"] for row in rows if row["volunteer"] == volunteer and row.get("labels")}
        if labelled and (lacking := [p for p in positions[volunteer] if p not in labelled]):
            raise ConfigurationError(
                f"{file}: volunteer {volunteer!r} has labels of {', '.join(sorted(labelled))} and none of "
                f"{', '.join(lacking)}; give labels of each of her positions, or of none"
            )


def absent(rows: Iterable[Row], *, there: Callable[[str], bool]) -> dict[str, str]:
    """Of each volunteer whose files are not all there, the first one that is not: 'images scans/ada'."""
    found: dict[str, str] = {}
    for row in rows:
        named = ((kind, row.get(kind) or "") for kind in ("images", "labels", "strokes", "fiducials"))
        for kind, path in named:
            if path and not there(path):
                found.setdefault(row["volunteer"], f"{kind} {path}")
    return found


def _faults(row: Row, file: str, there: Callable[[str], bool]) -> list[str]:
    """What is wrong with a row by itself."""
    try:
        _check_gravity(row["volunteer"], row["position"], row["gravity"], file)
        _check_given(row, file)
        _check_paths(row, file, there)
    except ConfigurationError as error:
        return [str(error)]
    return []


def _check_given(row: Row, file: str) -> None:
    """Raise ConfigurationError where neither labels are given nor images, of which labels are made."""
    if not row.get("labels") and not row.get("images"):
        raise ConfigurationError(
            f"{file}: volunteer {row['volunteer']!r}, {row['position']}, lacks images; give images, or labels"
        )
    _check_series(row, file)


def _check_series(row: Row, file: str) -> None:
    """Raise ConfigurationError where a series is named without images, or gaps are treated otherwise."""
    if (gaps := row.get("gaps") or "") not in GAPS:
        raise ConfigurationError(
            f"{file}: volunteer {row['volunteer']!r}, {row['position']}: gaps {gaps!r} is not known; write "
            f"{GAPS[1]!r} to have unevenly spaced slices interpolated, or nothing"
        )
    if not row.get("images") and (named := [name for name in ("series", "gaps") if row.get(name)]):
        raise ConfigurationError(
            f"{file}: volunteer {row['volunteer']!r}, {row['position']}, has {' and '.join(named)} without "
            "images; name the folder, zip or file of the series, too"
        )


def _check_paths(row: Row, file: str, there: Callable[[str], bool]) -> None:
    """Raise ConfigurationError where a path is not there, or the workflow would read it otherwise."""
    for kind in ("images", "labels", "codes", "strokes", "fiducials"):
        path = row.get(kind) or ""
        if kind == "codes" and path and not row.get("labels"):
            wrong = "codes explain labels; give labels, or leave codes out"
        elif kind == "codes" and is_preset(path):
            continue
        elif kind == "codes" and path and not there(path):
            wrong = f"is no file and no preset; presets are: {', '.join(presets())}"
        elif path.startswith("~"):
            wrong = "~ is not expanded here; write the whole path"
        elif "{" in path or "}" in path:
            wrong = "braces are wildcards of the workflow; rename it"
        elif path.startswith("results/") and path.split("/")[1] != "raw" and f"/{row['volunteer']}/" in path:
            wrong = "the study makes it of this row; give what was measured"
        elif path and not there(path):
            wrong = "is not there; correct the path, which begins where the study is run"
        else:
            continue
        raise ConfigurationError(
            f"{file}: volunteer {row['volunteer']!r}, {row['position']}: {kind} {path!r}: {wrong}"
        )


def _check_own(rows: Sequence[Row], file: str) -> None:
    """Raise ConfigurationError where two rows have the same images, or the same labels."""
    for kind in ("images", "labels"):
        first: dict[tuple[str, str], Row] = {}
        for row in rows:
            path = (row.get(kind) or "").rstrip("/")
            one = path, (row.get("series") or "") if kind == "images" else ""  # a folder may hold several
            if path and (other := first.setdefault(one, row)) is not row:
                whose = " and ".join(f"{r['volunteer']} {r['position']}" for r in (other, row))
                raise ConfigurationError(f"{file}: {kind} {path!r} are given for {whose}; give each its own")


def check_listed(rows: Iterable[Row], volunteers: Iterable[str], *, file: str) -> None:
    """Raise ConfigurationError when a volunteer has no row of the table of volunteers."""
    known = list(dict.fromkeys(row["volunteer"] for row in rows))
    if lacking := sorted(set(volunteers) - set(known)):
        raise ConfigurationError(
            f"{file} has no row of {', '.join(map(repr, lacking))}, whom `volunteers` names; it has rows of: "
            f"{', '.join(known) or 'nobody'}"
        )


def _check_gravity(volunteer: str, position: str, gravity: str, file: str) -> None:
    where = f"{file}: volunteer {volunteer!r}"
    if position not in GRAVITY:
        raise ConfigurationError(
            f"{where} has unknown position {position!r}; choose one of: {', '.join(GRAVITY)}"
        )
    try:
        g = gravity_vector(gravity)
    except ValueError:
        raise ConfigurationError(
            f"{where}, {position}: gravity {gravity!r} is no direction; write three numbers with decimal "
            "points, as '0 -1 0'"
        ) from None
    angle = float(np.degrees(np.arccos(np.clip(g[1], -1, 1))))
    low, high = ANGLE_TO_POSTERIOR_DEG[position]
    if not low <= angle <= high:
        raise ConfigurationError(
            f"{where}: gravity {gravity!r} is {angle:.0f} degrees from posterior, which contradicts "
            f"{position!r} ({low} to {high} degrees); correct the position, or the gravity "
            "(LPS: prone is '0 -1 0')"
        )


def check_tissues(tissues: Iterable[str], needed: Iterable[str], *, file: str) -> None:
    """Raise ConfigurationError when a tissue that segmentation produces has no parameters."""
    have = set(tissues)
    if absent := sorted(set(needed) - have):
        raise ConfigurationError(
            f"{file}: no parameters for tissue {', '.join(map(repr, absent))}; add youngs_modulus_kpa, "
            f"poisson_ratio and density_g_cm3 (the file has: {', '.join(sorted(have))})"
        )
