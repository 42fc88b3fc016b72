"""Plain values are read into settings, or rejected with the path of the key, limits and the next step."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Count, NotNegative, Positive, Settings, read


@dataclass(frozen=True)
class Wheel(Settings):
    """With everything that a setting can be."""

    radius_mm: Positive
    spokes: Count = 8
    rim: Literal["steel", "wood"] = "steel"
    worn: bool = False
    offset_mm: tuple[NotNegative, ...] = ()
    loads_n: Mapping[str, Positive] | None = None

    def __post_init__(self):
        super().__post_init__()
        if self.worn and self.rim == "steel":
            raise ConfigurationError("steel does not wear; choose wood")


@dataclass(frozen=True)
class Cart(Settings):
    """Of wheels."""

    wheels: tuple[Wheel, ...]


def test_values_become_what_the_annotations_say():
    cart = read(Cart, {"wheels": [{"radius_mm": 3, "offset_mm": [1, 2.5], "loads_n": {"left": 2}}]}, "cart")
    assert cart == Cart((Wheel(3.0, offset_mm=(1.0, 2.5), loads_n={"left": 2.0}),))
    assert isinstance(cart.wheels[0].radius_mm, float)
    assert cart.wheels[0].spokes == 8


@pytest.mark.parametrize(
    ("wheel", "words"),
    [
        ({"radius_m": 1}, r"cart.wheels\[0\] has no key 'radius_m'; did you mean 'radius_mm'\?"),
        ({}, r"cart.wheels\[0\] lacks radius_mm; add it"),
        ({"radius_mm": float("inf")}, r"wheels\[0\].radius_mm = inf is not a finite number; write one"),
        ({"radius_mm": 0}, r"wheels\[0\].radius_mm = 0 is outside \(0, inf\)"),
        ({"radius_mm": "3"}, r"radius_mm = '3' is of type str; write a float"),
        ({"radius_mm": True}, "radius_mm = True is of type bool; write a float"),
        ({"radius_mm": 1, "spokes": 2.5}, "spokes = 2.5 is of type float; write a int"),
        ({"radius_mm": 1, "spokes": 0}, r"spokes = 0 is outside \[1, inf\)"),
        ({"radius_mm": 1, "rim": "gold"}, "rim = 'gold': choose one of: steel, wood"),
        ({"radius_mm": 1, "offset_mm": 4}, r"offset_mm = 4 is no list; write \[...\]"),
        ({"radius_mm": 1, "offset_mm": [0, -4]}, r"offset_mm\[1\] = -4 is outside \[0, inf\)"),
        ({"radius_mm": 1, "loads_n": [1]}, "loads_n = .1. has no keys; write them as `key: value`"),
        ({"radius_mm": 1, "loads_n": {"left": -1}}, "loads_n.left = -1 is outside"),
        ({"radius_mm": 1, "worn": True}, r"cart.wheels\[0\]: steel does not wear; choose wood"),
    ],
)
def test_what_cannot_be_meant_is_rejected_by_its_path(wheel, words):
    with pytest.raises(ConfigurationError, match=words):
        read(Cart, {"wheels": [wheel]}, "cart")


def test_settings_guard_themselves_whoever_makes_them():
    with pytest.raises(ConfigurationError, match="radius_mm = nan is not a finite number"):
        Wheel(float("nan"))
