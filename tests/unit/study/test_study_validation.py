"""Distances of a predicted from a measured position, on bodies whose distance is known."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mammosim.chain.outcome import CONVERGED
from mammosim.core.errors import FiducialError, MeshError
from mammosim.core.fiducials import Fiducials
from mammosim.mechanics.body import Body
from mammosim.study.identification.validation import (
    Prediction,
    Start,
    errors,
    point_errors,
    predicted,
    rows,
    skin_distances,
    skin_errors,
)
from mammosim.study.sweep import one_law

POINTS = np.array([[40.0, -3.0, 50.0], [60.0, 0.0, 45.0], [50.0, -1.0, 55.0]])
FIDUCIALS = Fiducials(("breast_1", "breast_2", "nipple_left"), ("breast", "breast", "nipple"), POINTS)
SUPINE = np.array([0.0, 1, 0])


@pytest.fixture
def body(block):
    """A block of 100 mm: more than the middle of its skin lies beyond 20 mm of where it is held."""
    return block(4, 100.0)


def law(E):
    return Body(one_law(E, poisson_ratio=0.45, muscle_kpa=30.0, density_g_cm3=1.0))


def test_what_was_measured_is_at_no_distance_from_itself(body):
    start = Start(body, FIDUCIALS, body.points)
    found = errors(start, body.points, body, FIDUCIALS)
    assert max(found.values()) == pytest.approx(0, abs=1e-9)
    assert list(found)[:3] == list(FIDUCIALS.names)


def test_a_shift_is_the_error_of_every_marker_and_at_most_that_of_the_skin(body):
    shift = np.array([0.0, -4.0, 3.0])
    moved = Fiducials(FIDUCIALS.names, FIDUCIALS.kinds, POINTS + shift)
    found = errors(
        Start(body, FIDUCIALS, body.points), body.points, body.moved_to(body.points + shift), moved
    )
    points = [found[name] for name in (*FIDUCIALS.names, "marker_mean", "marker_max")]
    np.testing.assert_allclose(points, 5.0)
    assert 0 < found["skin_mean"] <= found["skin_p95"] <= found["skin_hausdorff"] <= 5.0 + 1e-9


def test_the_skin_near_a_cut_does_not_count(body):
    """Pulling the edges of the cut by 30 mm changes nothing 20 mm in front of it."""
    pulled = body.points.copy()
    behind = pulled[:, 1] > 99.0
    pulled[behind, 1] += 30.0
    assert skin_errors(body.moved_to(pulled), body)["skin_hausdorff"] < 1e-9


def test_the_distance_of_two_skins_is_the_same_both_ways(body):
    """A spike that only one skin has is as far from the other as the other is from it."""
    pulled = body.points.copy()
    tip = np.argmin(np.linalg.norm(pulled - [50.0, 0.0, 50.0], axis=1))
    pulled[tip, 1] -= 30.0
    spiked = body.moved_to(pulled)
    one, other = skin_distances(spiked, body), skin_distances(body, spiked)
    np.testing.assert_allclose(np.sort(one), np.sort(other))
    assert one.max() == pytest.approx(30.0)


def test_skins_beside_each_other_are_rejected(body):
    front = np.all(body.points[body.boundaries["skin"]][..., 1] == 0.0, axis=1)
    body = replace(body, boundaries={"skin": body.boundaries["skin"][front]})
    far = body.moved_to(body.points + [500.0, 0.0, 0.0])
    with pytest.raises(MeshError, match="do not lie opposite"):
        skin_distances(body, far)


def test_lists_without_a_common_marker_are_rejected():
    renamed = Fiducials(("left_1", "left_2", "nipple_left"), FIDUCIALS.kinds, POINTS)
    with pytest.raises(FiducialError, match="same names"):
        point_errors(FIDUCIALS, renamed)


def test_a_body_under_gravity_is_predicted_and_a_lost_one_is_an_outcome(block):
    mesh = block(2)
    start = Start(mesh, FIDUCIALS, mesh.points)
    stiff = predicted(start, law(100.0), SUPINE)
    assert stiff.outcome == CONVERGED
    # rho g h^2 / E = 0.09 mm for a column of 30 mm.
    assert 0.01 < np.abs(stiff.points - mesh.points).max() < 0.1
    lost = predicted(start, law(0.01), SUPINE)
    assert lost.outcome.startswith(("failed: ", "unstable: "))
    assert np.isnan(lost.points).all()


def test_a_prediction_that_failed_has_rows_without_numbers():
    before = {"nipple_left": 9.0, "skin_hausdorff": 12.0}
    table = rows(
        {"volunteer": "small", "position": "supine_tilted", "fitted": False},
        Prediction(np.full((4, 3), np.nan), "failed: too soft"),
        found={},
        before=before,
        published={"skin_hausdorff": 5.9},
    )
    assert table.value_mm.isna().all()
    assert table.before_mm.tolist() == [9.0, 12.0]
    assert table.published_mm.tolist()[1] == 5.9
    assert pd.isna(table.published_mm[0])
    assert set(table.outcome) == {"failed: too soft"}
