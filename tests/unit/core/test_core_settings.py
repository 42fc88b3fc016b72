"""Settings: what is written is what is meant, or the key that is not is named with its limits."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import (
    Limits,
    OneOf,
    Positive,
    Settings,
    SomeOf,
    Unchecked,
    looked_up,
    named_words,
    read,
    require_positive,
    require_within,
    words,
)


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
    assert words(Plate(2.5, count=0)) == "width mm 2.5, count 0, kind flat", "what is 0 is set"


@pytest.mark.parametrize(
    ("limits", "inside", "outside", "words"),
    [
        (Limits(at_least=0, at_most=1), (0, 1), (-0.1, 1.1), "[0, 1]"),
        (Limits(above=0, below=1), (0.1, 0.9), (0, 1), "(0, 1)"),
        (Limits(at_most=1), (-1e9, 1), (1.1,), "(-inf, 1]"),
        (Limits(at_least=0), (0, 1e9), (-0.1,), "[0, inf)"),
    ],
)
def test_the_ends_of_limits_belong_to_them_as_their_brackets_say(limits, inside, outside, words):
    for x in inside:
        limits.require(x, "x")
    for x in outside:
        with pytest.raises(ConfigurationError) as error:
            limits.require(x, "x")
        assert str(error.value) == f"x = {x:g} is outside {words}; change it"


def test_numbers_of_an_object_that_checks_itself_are_all_checked_and_ends_are_within():
    plate = Plate(2.0, count=0)
    require_positive(plate, "width_mm")
    with pytest.raises(ConfigurationError, match=r"count = 0 is outside \(0, inf\)"):
        require_positive(plate, "width_mm", "count")
    require_within("x", 1.0, 1.0, 2.0)
    require_within("x", 2.0, 1.0, 2.0)


@dataclass(frozen=True)
class Table(Settings):
    legs: dict = field(default_factory=dict)
    height_mm: Positive | tuple[float, ...] = 700.0

    def __post_init__(self):
        super().__post_init__()
        if self.height_mm == 1.0:
            raise ConfigurationError("height_mm = 1 is no table")


def test_what_has_a_default_may_be_left_out_and_whole_numbers_become_those_of_their_kind():
    assert read(Table, {}, "table") == Table({}, 700.0)
    assert type(read(Plate, {"width_mm": 5}, "plate").width_mm) is float


def test_of_several_kinds_the_first_says_what_is_wrong():
    assert read(Table, {"height_mm": [1, 2]}, "table").height_mm == (1.0, 2.0)
    with pytest.raises(ConfigurationError, match=r"table\.height_mm = -1 is outside \(0, inf\)"):
        read(Table, {"height_mm": -1}, "table")


def test_what_an_object_rejects_is_told_with_its_place():
    with pytest.raises(ConfigurationError, match=r"^room\.table: height_mm = 1 is no table$"):
        read(Table, {"height_mm": 1.0}, "room.table")


def test_settings_are_looked_up_by_the_name_of_their_group():
    values = {"plate.width_mm": 5, "plate.count": 2, "plate.kind": "bent"}
    assert looked_up(Plate, values.__getitem__, "plate") == Plate(5.0, 2, "bent")
