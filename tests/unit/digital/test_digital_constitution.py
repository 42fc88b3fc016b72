"""The mechanical parameters of a virtual patient, left and right apart."""

import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.core.tissues import TissueTable
from mammosim.digital.constitution import Constitution
from mammosim.digital.patient import VirtualPatient

LEFT = {"adipose": 0.6, "glandular": 1.8, "skin": 9.0, "muscle": 20.0}
RIGHT = {"adipose": 0.9, "glandular": 1.2, "skin": 14.0, "muscle": 30.0}


@pytest.fixture(scope="module")
def values(repository):
    return yaml.safe_load((repository / "config/tissues/volunteer.yaml").read_text())


@pytest.fixture(scope="module")
def common(values):
    return read(TissueTable, values, "tissues")


def patient(women, **own):
    return VirtualPatient.read(women["small"] | own)


def test_both_sides_have_the_common_moduli_unless_she_has_her_own(women, common):
    table = Constitution.of(patient(women), common).moduli()
    assert list(table.tissue) == ["adipose", "glandular", "skin", "fascia", "muscle"] * 2
    assert list(table.side) == ["left"] * 5 + ["right"] * 5
    assert list(table.true_kpa) == [0.8, 2.0, 12.0, 0.0, 25.0] * 2


def test_each_side_has_its_own_moduli(women, common):
    own = patient(women, moduli_kpa={"left": LEFT, "right": RIGHT})
    table = Constitution.of(own, common).moduli().set_index(["side", "tissue"]).true_kpa
    for side, moduli in (("left", LEFT), ("right", RIGHT)):
        assert table[side].to_dict() == {**moduli, "fascia": 0.0}


def test_a_side_without_all_its_moduli_is_rejected(women):
    lacking = {name: E for name, E in RIGHT.items() if name != "skin"} | {"fat": 1.0}
    with pytest.raises(ConfigurationError, match=r"moduli_kpa\.right has no key 'fat'"):
        patient(women, moduli_kpa={"left": LEFT, "right": lacking})


def test_a_modulus_that_is_none_is_rejected(women):
    for E, words in (
        (0.0, r"left: skin = 0 is outside \(0, inf\)"),
        ("soft", "left.skin = 'soft' is of type"),
    ):
        with pytest.raises(ConfigurationError, match=words):
            patient(women, moduli_kpa={"left": LEFT | {"skin": E}, "right": RIGHT})


def test_tissues_that_do_not_make_a_body_are_named(women, values):
    no_skin = read(TissueTable, {"tissues": values["tissues"]}, "tissues")
    with pytest.raises(ConfigurationError, match=r"lack skin; add them to the file of digital\.tissues"):
        Constitution.of(patient(women), no_skin)
    for change, words in (
        ({"fat": values["tissues"]["adipose"]}, "tissues: unknown tissue 'fat'"),
        ({"adipose": {"youngs_modulus_kpa": 500}}, r"tissues\.tissues\.adipose lacks poisson_ratio"),
    ):
        with pytest.raises(ConfigurationError, match=words):
            read(TissueTable, values | {"tissues": values["tissues"] | change}, "tissues")


def test_a_virtual_patient_is_written_as_she_is_read(women):
    fibrous = VirtualPatient.read(women["fibrous"])
    assert VirtualPatient.read(fibrous.values()) == fibrous
    assert fibrous.values()["ligaments"]["stiffness_kpa"] == 1.0
    assert "moduli_kpa" not in fibrous.values()
