"""Settings: what is written is what is meant, or the key that is not is named with its limits."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Limits, OneOf, Settings, SomeOf, Unchecked, named_words, read, words


@dataclass(frozen=True)
class Plate(Settings):
    width_mm: Annotated[float, Limits(above=0, at_most=100, advice="was it given in m?")]
    count: int = 1
    kind: Literal["flat", "bent"] = "flat"


@dataclass(frozen=True)
class RoundPlate(Settings):
    """Of any radius."""

    radius_mm: Unchecked
    hole: Plate | None = None


KINDS = {"plate": Plate, "round": RoundPlate}


@dataclass(frozen=True)
class Machine(Settings):
    plates: Mapping[str, Plate]
    size: tuple[float, float] = (1.0, 1.0)
    paddle: Annotated[Plate | RoundPlate, OneOf(KINDS)] | None = None
    parts: Annotated[tuple[Plate | RoundPlate, ...], SomeOf(KINDS)] = ()


def test_plain_values_become_objects():
    found = read(
        Machine, {"plates": {"low": {"width_mm": 5}}, "paddle": {"round": {"radius_mm": 3}}}, "machine"
    )
    assert found.plates == {"low": Plate(5.0)}
    assert found.paddle == RoundPlate(3.0)
    assert read(
        Machine, {"plates": {}, "parts": {"plate": {"width_mm": 1}, "round": {"radius_mm": 2}}}, "m"
    ).parts == (
        Plate(1.0),
        RoundPlate(2.0),
    )


def test_what_is_made_without_a_file_is_guarded_too():
    assert Machine(plates={}, size=[2, 3]).size == (2.0, 3.0)
    with pytest.raises(ConfigurationError, match=r"width_mm = 0 is outside \(0, 100\]; was it given in m\?"):
        Plate(0)


def test_only_what_is_unchecked_may_be_no_number():
    assert np.isnan(RoundPlate(np.nan).radius_mm)
    with pytest.raises(ConfigurationError, match="size\\[1\\] = inf is not a finite number"):
        Machine(plates={}, size=(1.0, np.inf))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "machine lacks plates; add it"),
        ({"plates": [5]}, r"machine\.plates = \[5\] has no keys"),
        (
            {"plates": {"low": {"width": 5}}},
            r"machine\.plates\.low has no key 'width'; did you mean 'width_mm'\?",
        ),
        ({"plates": {"low": {"zzz": 5}}}, "choose one of: width_mm, count, kind"),
        ({"plates": {"low": {"width_mm": True}}}, r"low\.width_mm = True is of type bool; write a number"),
        (
            {"plates": {"low": {"width_mm": 5, "count": 1.5}}},
            r"low\.count = 1.5 is of type float; write a whole number",
        ),
        (
            {"plates": {"low": {"width_mm": 5, "kind": "round"}}},
            r"low\.kind = 'round': choose one of: flat, bent",
        ),
        ({"plates": {"low": {"width_mm": 10**400}}}, r"low\.width_mm = inf is not a finite number"),
        ({"plates": {"low": {"width_mm": 5, "count": -(10**400)}}}, r"low\.count = -inf is not a finite"),
        ({"plates": {}, "size": [1]}, r"machine\.size has 1 values; write 2"),
        (
            {"plates": {}, "paddle": {"plate": {}, "round": {}}},
            r"paddle has 2 keys; give one of: plate, round",
        ),
        ({"plates": {}, "parts": {}}, r"parts has 0 keys; give one of: plate, round"),
        (
            {"plates": {}, "parts": {"disc": {}}},
            r"parts\.disc: 'disc' is unknown; choose one of: plate, round",
        ),
    ],
)
def test_an_error_names_the_path_of_keys(values, message):
    with pytest.raises(ConfigurationError, match=message):
        read(Machine, values, "machine")


def test_settings_are_said_in_words():
    assert named_words(RoundPlate(3.0)) == "round plate radius mm 3"
    assert words(Plate(2.5)) == "width mm 2.5, count 1, kind flat"
