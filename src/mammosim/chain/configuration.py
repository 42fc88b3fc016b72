"""Reject a configuration that cannot be meant before anything is computed, and say what to write instead."""

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

import numpy as np
from jsonschema import Draft202012Validator, ValidationError

from mammosim.core.errors import ConfigurationError
from mammosim.core.positions import GRAVITY, gravity_vector

# Angle between the stated gravity and +y (posterior), degrees: what each position can mean.
ANGLE_TO_POSTERIOR_DEG = {
    "prone": (150, 180),
    "supine": (0, 20),
    "supine_tilted": (20, 80),
    "upright": (60, 120),
}


def check_settings(settings: Mapping[str, Any], schema: Mapping[str, Any], *, files: Iterable[str]) -> None:
    """Raise ConfigurationError with every unknown key and every value outside its limits.

    settings: nested values as read; schema: JSON schema (2020-12) with a description of each key;
    files: where the values came from, named in the message.
    """
    errors = sorted(
        Draft202012Validator(schema).iter_errors(settings), key=lambda e: list(map(str, e.absolute_path))
    )
    if errors:
        lines = "\n  ".join(_advice(error) for error in errors)
        raise ConfigurationError(f"{', '.join(files)}:\n  {lines}")


def _advice(error: ValidationError) -> str:
    place = ".".join(map(str, error.absolute_path)) or "the configuration"
    about = error.schema.get("description", "")
    if error.validator == "additionalProperties":
        known = sorted(error.schema.get("properties", {}))
        unknown = sorted(set(error.instance) - set(known))
        return "; ".join(_unknown_key(place, key, known) for key in unknown)
    if error.validator == "required":
        absent = sorted(set(error.validator_value) - set(error.instance))
        return f"{place} lacks {', '.join(absent)}; add it, or take it from config/default.yaml"
    return f"{place} = {error.instance!r}: {_limit(error)}. {about}".rstrip()


def _unknown_key(place: str, key: str, known: list[str]) -> str:
    near = get_close_matches(key, known, n=1)
    meant = f"did you mean {near[0]!r}?" if near else f"choose one of: {', '.join(known)}"
    return f"{place} has no key {key!r}; {meant}"


def _limit(error: ValidationError) -> str:
    limit = error.validator_value
    found: str = {
        "minimum": f"must be at least {limit}",
        "exclusiveMinimum": f"must be more than {limit}",
        "maximum": f"must be at most {limit}",
        "exclusiveMaximum": f"must be less than {limit}",
        "enum": f"choose one of: {limit}",
        "type": f"must be of type {limit}",
    }.get(str(error.validator), error.message)
    return found


Row = Mapping[str, str]


def check_volunteers(rows: Sequence[Row], *, file: str, reference_position: str) -> None:
    """Raise ConfigurationError unless each row names a known position that agrees with its gravity.

    rows: of volunteer, position, images, fiducials, strokes, gravity ('x y z', scanner frame LPS).
    Each volunteer needs prone and the reference position, each position once.
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
    for row in rows:
        _check_gravity(row["volunteer"], row["position"], row["gravity"], file)
    for volunteer, found in positions.items():
        if absent := {"prone", reference_position} - set(found):
            raise ConfigurationError(
                f"{file}: volunteer {volunteer!r} lacks {', '.join(sorted(absent))}; prone and the reference "
                f"position {reference_position!r} are needed"
            )


def check_thicknesses(thickness_mm: Mapping[str, float], volunteers: Iterable[str]) -> None:
    """Raise ConfigurationError when a volunteer has no thickness of the standard compression."""
    if lacking := [v for v in volunteers if v not in thickness_mm]:
        raise ConfigurationError(
            f"compression.thickness_mm lacks {', '.join(lacking)}; add the thickness in mm of her standard "
            "compression, 40 to 70 is usual"
        )


def check_listed(rows: Iterable[Row], volunteers: Iterable[str], *, file: str) -> None:
    """Raise ConfigurationError when a volunteer has no row of the table of volunteers."""
    known = list(dict.fromkeys(row["volunteer"] for row in rows))
    if lacking := sorted(set(volunteers) - set(known)):
        raise ConfigurationError(
            f"{file} has no row of {', '.join(map(repr, lacking))}, whom `volunteers` names; it has rows of: "
            f"{', '.join(known)}"
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
            f"{where}, {position}: gravity {gravity!r} is no direction; write three numbers, as '0 -1 0'"
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
