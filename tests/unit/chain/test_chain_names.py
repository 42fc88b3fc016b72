"""A position, effect, paddle or tissue that is added in one place is known in all others (docs/extend.md)."""

from functools import reduce
from operator import getitem

import pytest
import yaml

from mammosim.chain.configuration import ANGLE_TO_POSTERIOR_DEG
from mammosim.chain.mammogram import tissue_materials
from mammosim.chain.paddles import PARTS
from mammosim.chain.stages import STAGES, effects_on
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.positions import GRAVITY
from mammosim.figures.style import TISSUE_COLOURS


@pytest.fixture
def enumerated(repository):
    """A schema's value at a path of keys."""

    def read(name: str, *path: str):
        return reduce(
            getitem, path, yaml.safe_load((repository / f"workflow/schemas/{name}.yaml").read_text())
        )

    return read


@pytest.mark.parametrize("name", ["scene", "campaign", "accuracy"])
def test_the_schemas_know_every_position(enumerated, name):
    path = ("properties", "load", "properties", "position", "enum")
    assert set(enumerated(f"{name}.schema", *path)) == set(GRAVITY)


def test_every_position_has_its_angles():
    assert set(ANGLE_TO_POSTERIOR_DEG) == set(GRAVITY)


def test_the_schema_knows_every_effect(enumerated):
    found = [
        name
        for part in ("mechanics", "xray")
        for name in enumerated("config.schema", "properties", part, "properties", "effects", "items", "enum")
    ]
    assert len(found) == len(set(found))
    assert set(found) == effects_on(STAGES)


def test_the_schema_knows_every_part_of_a_plate(enumerated):
    strategy = enumerated("compression.schema", "patternProperties", "^[a-z0-9]+$", "properties")
    assert set(strategy["paddle"]["properties"]) == set(PARTS)


def test_every_tissue_has_a_colour_and_each_that_deforms_its_material():
    assert set(TISSUE_COLOURS) == set(Label)
    assert set(tissue_materials()) >= set(DEFORMABLE)


def test_the_published_study_has_every_setting_that_a_stage_reads(repository):
    """But for those that a job gives: the load, the tissues, and how labels are coded."""
    default = yaml.safe_load((repository / "config/default.yaml").read_text())
    given = ("load", "labels", "tissues")
    read = {tuple(key.split(".")) for stage in STAGES.values() for key in stage.reads}
    for key in (key for key in read if key[0] not in given):
        reduce(getitem, key, default)
