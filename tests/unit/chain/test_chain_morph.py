from dataclasses import replace

import numpy as np
import pytest

from mammosim.chain.morph import MorphSettings, morphed, sound_mean
from mammosim.core.errors import MeshError
from mammosim.mechanics.reference import smallest_jacobians
from mammosim.meshing.shapes import ball_part

# Both boundaries are drawn and none is held: the base of the ball grows with it.
ALL_OVER = MorphSettings(drawn=("skin", "posterior"), held=(), stiffness_kpa_per_mm=(0.1, 1.0, 10.0))
STRETCH = np.array([1.2, 1.2, 0.8])


@pytest.fixture(scope="module")
def ball():
    return ball_part(30.0, 12.0)


@pytest.fixture(scope="module")
def ellipsoid():
    """A finer half ball, stretched sideways and flattened."""
    finer = ball_part(30.0, 8.0)
    return finer.moved_to(finer.points * STRETCH)


def test_a_mesh_stays_where_it_already_has_the_shape(ball):
    found = morphed(ball, ball)
    # Nearest points lie on flat quarters of curved faces: sagitta (6 mm)^2 / (8 * 30 mm) at most.
    assert np.abs(found.points - ball.points).max() < 0.15
    assert found.history[-1].mean_mm < 0.05


def test_a_half_ball_becomes_the_half_ellipsoid_without_folds(ball, ellipsoid):
    found = morphed(ball, ellipsoid, settings=ALL_OVER)
    start, end = found.history[0], found.history[-1]
    assert start.mean_mm > 2.0
    # The coarser mesh cannot follow the target closer than its own flat quarters, see above.
    assert end.mean_mm < 0.15
    assert end.back_mean_mm < 0.15
    assert smallest_jacobians(found.points, ball.cells).min() > 0
    apex = np.argmax(ball.points[:, 2])
    assert found.points[apex, 2] == pytest.approx(30 * STRETCH[2], abs=0.3)


def test_a_held_boundary_stays_to_the_last_bit(ball, ellipsoid):
    found = morphed(ball, ellipsoid, settings=MorphSettings(stiffness_kpa_per_mm=(0.03,)))
    base = ball.boundary_nodes("posterior")
    assert np.array_equal(found.points[base], ball.points[base])


def test_a_stiffer_attraction_comes_nearer_and_strains_more(ball, ellipsoid):
    found = morphed(ball, ellipsoid, settings=ALL_OVER)
    distance = [step.mean_mm for step in found.history]
    energy = [step.energy_uj for step in found.history]
    assert np.all(np.diff(distance) < 0)
    assert np.all(np.diff(energy) > 0)


def test_what_lies_beyond_the_rim_of_the_target_is_not_drawn_back(ball):
    """The target is the same ball cut off 9 mm higher: the skin below the cut faces nothing, and stays."""
    skin = ball.boundaries["skin"]
    above = np.all(ball.points[skin][:, :3, 2] > 9.0, axis=1)
    target = replace(ball, boundaries={"skin": skin[above]})
    found = morphed(ball, target, settings=MorphSettings(held=()))
    assert np.abs(found.points - ball.points).max() < 0.15
    assert found.history[-1].max_mm > 8.0
    assert found.history[-1].facing_max_mm < 0.2


def test_a_morph_that_would_fold_a_cell_is_rejected_with_the_way_out(ball, ellipsoid):
    # The target has 1.15 of the ball's volume but is 0.8 as high; no map onto it keeps 0.999 everywhere.
    settings = replace(ALL_OVER, stiffness_kpa_per_mm=(100.0,), smallest_J=0.999)
    with pytest.raises(MeshError, match=r"folds .* of .* cells.*lower stiffness_kpa_per_mm"):
        morphed(ball, ellipsoid, settings=settings)


def test_a_missing_boundary_is_rejected(ball):
    bare = replace(ball, boundaries={"posterior": ball.boundaries["posterior"]})
    with pytest.raises(MeshError, match="no boundary 'skin'"):
        morphed(ball, bare)
    with pytest.raises(MeshError, match="no boundary 'skin'"):
        morphed(bare, ball)


def test_a_folded_mesh_is_rejected(ball):
    folded = ball.moved_to(ball.points * [1, 1, -1])
    with pytest.raises(MeshError, match="inverted cells"):
        morphed(folded, ball)


def test_the_mean_stops_short_where_halfway_would_fold(ball):
    assert sound_mean(ball, ball.points * STRETCH).share == 0.5
    mirrored = sound_mean(ball, ball.points * [1.0, 1.0, -1.5])  # halfway every cell is inverted
    assert 0 < mirrored.share < 0.4
    assert smallest_jacobians(mirrored.points, ball.cells).min() > 0
