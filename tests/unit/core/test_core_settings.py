"""What a reader of settings rejects, and how it says where."""

from collections.abc import Mapping
from dataclasses import dataclass

import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import looked_up, read, require_positive, require_within


@dataclass(frozen=True)
class Size:
    width_mm: float
    count: int = 1

    def __post_init__(self) -> None:
        require_within("width_mm", self.width_mm, 1, 10, "given in cm?")
        require_positive(self, "count")


@dataclass(frozen=True)
class Group:
    size: Size
    name: str
    levels: tuple[float, ...] = ()
    pair: tuple[int, int] = (1, 2)
    kpa: Mapping[str, float] | None = None


VALUES = {"size": {"width_mm": 2}, "name": "a"}


def test_values_become_objects_and_what_has_a_default_may_be_left_out():
    found = read(Group, VALUES | {"levels": [0.1, 2], "kpa": {"fat": 1.0}}, at="group")
    assert found == Group(Size(2), "a", (0.1, 2), kpa={"fat": 1.0})
    assert read(Group, VALUES | {"kpa": None}, at="group") == Group(Size(2), "a")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"siez": 1},
            r"^group: missing \[\], unknown \['siez'\]; give exactly: size, name, levels, pair, kpa$",
        ),
        ({"size": {}}, r"^group\.size: missing \['width_mm'\], unknown \[\]"),
        ({"size": 3}, r"^group\.size = 3 is no group of settings; give: width_mm, count"),
        ({"size": {"width_mm": "2"}}, r"^group\.size\.width_mm = '2' must be a finite number"),
        ({"size": {"width_mm": float("nan")}}, r"^group\.size\.width_mm = nan must be a finite number"),
        ({"size": {"width_mm": True}}, "must be a finite number"),
        ({"size": {"width_mm": 20}}, r"^group\.size: width_mm = 20 is outside \[1, 10\]; given in cm\?"),
        ({"size": {"width_mm": 2, "count": 1.5}}, r"^group\.size\.count = 1\.5 must be a whole number"),
        ({"size": {"width_mm": 2, "count": 0}}, r"^group\.size: count = 0 must be above 0"),
        ({"name": 5}, r"^group\.name = 5 must be a word"),
        ({"levels": 0.1}, r"^group\.levels = 0\.1 must be a list"),
        ({"levels": [0.1, float("inf")]}, r"^group\.levels\[1\] = inf must be a finite number"),
        ({"pair": [1]}, r"^group\.pair = \[1\] must be a list of 2 values"),
        ({"kpa": {"fat": "soft"}}, r"^group\.kpa\.fat = 'soft' must be a finite number"),
        ({"kpa": [1.0]}, r"^group\.kpa = \[1\.0\] must be a mapping"),
    ],
)
def test_what_is_no_setting_is_rejected_with_its_place(change, words):
    with pytest.raises(ConfigurationError, match=words):
        read(Group, VALUES | change, at="group")


def test_settings_are_looked_up_by_their_dotted_names():
    known = {"mesh.width_mm": 3.0, "mesh.count": 2}
    assert looked_up(Size, known.__getitem__, "mesh") == Size(3.0, 2)
