"""What a digital volunteer is made of, left and right apart."""

import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.digital.constitution import Constitution

LEFT = {"adipose": 0.6, "glandular": 1.8, "skin": 9.0, "muscle": 20.0}
RIGHT = {"adipose": 0.9, "glandular": 1.2, "skin": 14.0, "muscle": 30.0}


@pytest.fixture(scope="module")
def common(repository):
    return yaml.safe_load((repository / "config/tissues/volunteer.yaml").read_text())


def test_both_sides_have_the_common_moduli_unless_she_has_her_own(common):
    table = Constitution.from_parameters({}, common).moduli()
    assert list(table.tissue) == ["adipose", "glandular", "skin", "fascia", "muscle"] * 2
    assert list(table.side) == ["left"] * 5 + ["right"] * 5
    assert list(table.true_kpa) == [0.8, 2.0, 12.0, 0.0, 25.0] * 2


def test_each_side_has_its_own_moduli(common):
    woman = {"moduli_kpa": {"left": LEFT, "right": RIGHT}}
    table = Constitution.from_parameters(woman, common).moduli().set_index(["side", "tissue"]).true_kpa
    for side, moduli in (("left", LEFT), ("right", RIGHT)):
        assert table[side].to_dict() == {**moduli, "fascia": 0.0}


def test_a_side_without_all_its_moduli_is_refused(common):
    lacking = {name: E for name, E in RIGHT.items() if name != "skin"} | {"fat": 1.0}
    with pytest.raises(ConfigurationError, match=r"right: missing \['skin'\], unknown \['fat'\]"):
        Constitution.from_parameters({"moduli_kpa": {"left": LEFT, "right": lacking}}, common)
