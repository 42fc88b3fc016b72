"""Tissues, fiducials, positions and streams guard their own validity."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError, FiducialError, MechanicsError
from mammosim.core.fiducials import Fiducials, midline_mm
from mammosim.core.labels import Label
from mammosim.core.positions import GRAVITY, gravity_direction
from mammosim.core.progress import progress
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue, tissue_of


def test_moduli_follow_from_youngs_modulus_and_poissons_ratio():
    tissue = Tissue(3.0, 0.25, 1.0)
    assert tissue.shear_modulus_kpa == pytest.approx(1.2)  # E / (2 (1 + nu))
    assert tissue.bulk_modulus_kpa == pytest.approx(2.0)  # E / (3 (1 - 2 nu))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((-1.0, 0.45, 1.0), "outside"),
        ((3e5, 0.45, 1.0), "was it given in Pa"),
        ((1.0, 0.5, 1.0), r"outside \[0, 0.5\)"),
        ((1.0, 0.45, -1.0), "negative"),
    ],
)
def test_an_impossible_tissue_is_rejected(values, words):
    with pytest.raises(MechanicsError, match=words):
        Tissue(*values)


def test_a_tissue_without_parameters_is_named():
    with pytest.raises(MechanicsError, match="'glandular' is in the mesh but has no parameters"):
        tissue_of(Label.GLANDULAR, {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)})


def test_gravity_is_a_unit_vector_in_every_position():
    for position in GRAVITY:
        assert np.linalg.norm(gravity_direction(position)) == pytest.approx(1)


def test_an_unknown_position_is_rejected():
    with pytest.raises(ConfigurationError, match="unknown position 'sitting'; choose one of: prone"):
        gravity_direction("sitting")


def test_fiducials_have_unique_names_and_known_kinds():
    with pytest.raises(FiducialError, match="a stands twice; fiducial names must be unique: rename"):
        Fiducials(("a", "a"), ("chest", "chest"), np.zeros((2, 3)))
    with pytest.raises(FiducialError, match="unknown kind"):
        Fiducials(("a",), ("elbow",), np.zeros((1, 3)))
    with pytest.raises(
        FiducialError, match=r"no fiducial 'nipple_left'; the list has: a; mark it in the image"
    ):
        Fiducials(("a",), ("chest",), np.zeros((1, 3))).point("nipple_left")


@pytest.mark.parametrize(
    ("left", "right", "middle"), [(90.0, -70.0, 0.0), (310.0, 150.0, 230.0), (-20.0, -180.0, -100.0)]
)
def test_the_midline_is_between_the_nipples_where_a_frame_begins_elsewhere(left, right, middle):
    points = np.array([[left, -40.0, 0.0], [right, -40.0, 0.0]])
    nipples = Fiducials(("nipple_left", "nipple_right"), ("nipple",) * 2, points)
    assert midline_mm(nipples) == middle
    assert midline_mm(Fiducials(nipples.names[:1], ("nipple",), points[:1])) == 0.0, "of one nothing is known"


def test_a_stream_depends_on_its_name_alone():
    assert generator(1, "a", "b").random() == generator(1, "a", "b").random()
    assert generator(1, "a", "b").random() != generator(1, "ab").random()


def test_progress_yields_everything_and_says_how_far_it_is(caplog):
    with caplog.at_level("INFO", logger="mammosim.progress"):
        assert list(progress("abc", label="letters", total=3)) == ["a", "b", "c"]
    assert "letters 3/3" in caplog.text
