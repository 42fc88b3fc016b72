"""The inverse formulation finds the reference whose equilibrium is the measured shape."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import EquilibriumError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.body import Body, Skin
from mammosim.mechanics.inverse import Measured, inverse, linearised

HANGING = np.array([0.0, 0.0, 1.0])
STANDING = -HANGING


def body(E=1.0, nu=0.45, skin=True):
    return Body({Label.ADIPOSE: Tissue(E, nu, 1.0)}, (Skin(5.0, nu, 1.5),) if skin else ())


@pytest.fixture(scope="module")
def truth():
    return box((2, 2, 2), (50.0, 50.0, 50.0))


@pytest.mark.parametrize(
    "made_of", [body(), body(nu=0.495), body(E=3.0, skin=False)], ids=["skin", "mixed", "bulk"]
)
def test_what_is_found_is_the_reference_itself(truth, made_of):
    """The unknowns are those of the truth's own mesh, so nothing but the tolerance is between the two."""
    with shared_analysis():
        measured = truth.moved_to(made_of.load(truth, HANGING).points)
        found = inverse(measured, made_of, gravity=HANGING)
    moved = np.linalg.norm(measured.points - truth.points, axis=1).max()
    assert np.linalg.norm(found.points - truth.points, axis=1).max() < 1e-4 * moved


def test_newton_converges_at_least_superlinearly(truth):
    measured = truth.moved_to(body().load(truth, HANGING).points)
    history = inverse(measured, body(), gravity=HANGING).history
    corrections = np.array([row.max_mm for row in history])
    # Each system is solved to 2 %, which alone would be a factor of 50 an iteration near the end.
    assert np.all(corrections[3:] < 0.1 * corrections[2:-1])


def test_the_derivative_is_that_of_the_forces(truth):
    """Against a central difference of larger steps, whose error is of second order."""
    measured = truth.moved_to(body(skin=False).load(truth, HANGING).points)
    problem = Measured(measured, body(skin=False), HANGING)
    V = np.sin(truth.points / 20)
    with linearised(problem, truth.points) as at:
        h = 1e-3
        central = (problem.forces(truth.points + h * V) - problem.forces(truth.points - h * V)) / (2 * h)
        assert at.along(V) == pytest.approx(central, abs=1e-5 * np.abs(central).max())


def test_a_shape_too_tall_for_its_modulus_has_no_reference(truth):
    """Hung up, 50 mm of 0.02 kPa would have been drawn out from almost nothing."""
    with pytest.raises(EquilibriumError, match=r"raise its modulus|make all stiffnesses"):
        inverse(truth, body(E=0.02, skin=False), gravity=HANGING)
