"""The stress-free shape, loaded again, is the measured one: every method, how it fails, and its parts."""

from dataclasses import dataclass

import numpy as np
import pytest
from mechanics_bodies import HANGING, LIGHT, box

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body
from mammosim.mechanics.fixed_point import Tried, accelerated, carried, held_as_measured, nodal_inverses
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading import METHODS

BODY = LIGHT
ITERATED = ("fixed_point", "pull_back", "mean_start", "anderson")
NODAL = ("fixed_point", "pull_back", "anderson")


@pytest.fixture(scope="module")
def mean(truth, measured):
    """Of hanging and standing."""
    return (measured.points + BODY.load(truth, -HANGING).points) / 2


def distances(one, other):
    return np.linalg.norm(one - other, axis=1)


@pytest.mark.parametrize("method", [*ITERATED, "inverse"])
def test_the_true_shape_is_found(method, truth, measured, mean):
    settings = UnloadingSettings(tolerance_mm=0.01)
    found = METHODS[method](measured, BODY, gravity=HANGING, start=mean, settings=settings)
    assert found.history[-1].max_mm <= 0.01
    skin = measured.boundary_nodes("skin")
    # The load stretches this body by a tenth, so errors of the shapes are of the size of the residual.
    assert distances(found.points, truth.points)[skin].mean() <= 2 * 0.01
    assert [row.iteration for row in found.history] == list(range(len(found.history)))


@pytest.mark.parametrize("method", [*NODAL, "inverse"])
def test_a_method_that_drives_all_nodes_brings_the_inside_back_too(method, measured):
    found = METHODS[method](measured, BODY, gravity=HANGING)
    again = BODY.load(measured.moved_to(found.points), HANGING).points
    # The tolerance, and the solver's own of 1e-8 of the load, on displacements of 5 mm.
    assert distances(again, measured.points).max() <= UnloadingSettings().tolerance_mm + 1e-6


@pytest.mark.parametrize("method", ITERATED)
def test_the_residual_falls_at_every_iteration(method, measured, mean):
    found = METHODS[method](measured, BODY, gravity=HANGING, start=mean)
    assert np.all(np.diff([row.mean_mm for row in found.history]) < 0)


def test_reverse_gravity_is_near_for_small_strain_and_far_for_large(truth):
    """Its error is of second order: twice the gravity leaves about 4 times the error."""
    errors = []
    for density in (0.1, 0.2):
        body = Body({Label.ADIPOSE: Tissue(1.0, 0.45, density)})
        measured = truth.moved_to(body.load(truth, HANGING).points)
        found = METHODS["reverse_gravity"](measured, body, gravity=HANGING)
        errors.append(distances(found.points, truth.points).mean())
    assert errors[1] / errors[0] == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize("method", ITERATED)
def test_a_start_at_the_truth_is_accepted_at_once(method, truth, measured):
    warm = METHODS[method](measured, BODY, gravity=HANGING, start=truth.points)
    # The truth loads to the measured shape, to the solver's tolerance.
    assert len(warm.history) == 1


def test_the_mean_is_a_better_start_than_the_measured_shape(measured, mean):
    cold, warm = (METHODS["fixed_point"](measured, BODY, gravity=HANGING, start=s) for s in (None, mean))
    assert warm.history[0].mean_mm < cold.history[0].mean_mm / 2
    assert len(warm.history) < len(cold.history)


def test_mean_start_without_a_mean_is_rejected(measured):
    with pytest.raises(MechanicsError, match="mean of the prone and the supine shape of the same mesh"):
        METHODS["mean_start"](measured, BODY, gravity=HANGING)


def test_acceleration_saves_iterations():
    """A block that its weight stretches by half, where a plain fixed point converges slowly."""
    body = Body({Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)})
    truth = box((2, 2, 2), (50.0, 50.0, 50.0))
    measured = truth.moved_to(body.load(truth, HANGING).points)
    settings = UnloadingSettings(tolerance_mm=1e-3, max_iterations=100)
    plain, fast = (
        METHODS[name](measured, body, gravity=HANGING, settings=settings)
        for name in ("fixed_point", "anderson")
    )
    assert len(fast.history) < len(plain.history)
    assert fast.history[-1].max_mm <= 1e-3


def test_the_accelerated_step_solves_a_linear_problem_in_as_many_steps_as_unknowns():
    """u = b - A X: two unknowns, so three guesses give the solution exactly."""
    A, b = np.array([[1.5, 0.4], [0.2, 0.3]]), np.array([1.0, -2.0])
    guesses = np.array([[0.0, 0.0], [1.0, 0.0], [0.3, 1.0]])
    past = [Tried(X[None], (b - A @ X)[None]) for X in guesses]
    assert past[-1].X + accelerated(past) == pytest.approx(np.linalg.solve(A, b)[None])


def test_a_fixed_point_that_is_not_reached_fails(measured):
    settings = UnloadingSettings(tolerance_mm=1e-6, max_iterations=2)
    with pytest.raises(MechanicsError, match="2 fixed-point iterations left a distance"):
        METHODS["fixed_point"](measured, BODY, gravity=HANGING, settings=settings)


@dataclass(frozen=True)
class OnceLoaded(Body):
    """A body that has an equilibrium from rest only, or none at all."""

    ever: bool = True

    def load(self, mesh, gravity, *, start=None, settings=None):
        if start is not None or not self.ever:
            raise EquilibriumError("lost")
        return super().load(mesh, gravity, settings=settings)


@pytest.mark.parametrize("method", NODAL)
def test_divergence_fails_with_its_reason(method, measured):
    with pytest.raises(
        MechanicsError, match=r"diverges at a mean of .* has no equilibrium .*raise its modulus"
    ):
        METHODS[method](measured, OnceLoaded(BODY.tissues), gravity=HANGING)


def test_a_first_guess_without_equilibrium_fails_with_advice(measured):
    with pytest.raises(
        MechanicsError, match=r"first guess has no equilibrium under gravity \(lost\); give a"
    ):
        METHODS["fixed_point"](measured, OnceLoaded(BODY.tissues, ever=False), gravity=HANGING)


def test_a_start_is_moved_to_where_the_body_is_held(truth, measured):
    """A start that lies 3 mm off is carried back as a whole: nothing is strained by that."""
    off = truth.points + [3.0, 0.0, 0.0]
    assert held_as_measured(off, measured) == pytest.approx(truth.points, abs=1e-9)


def test_the_inverse_gradient_of_an_affine_map_is_that_of_the_map(truth):
    F = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]])
    inverses = nodal_inverses(truth, truth.points @ F.T)
    assert inverses == pytest.approx(np.broadcast_to(np.linalg.inv(F), inverses.shape))


def test_carrying_an_affine_displacement_gives_it_everywhere(truth):
    u = truth.points @ np.array([[0.1, 0.02, 0.0], [0.0, -0.05, 0.03], [0.01, 0.0, 0.04]])
    outer = np.zeros(len(u), dtype=bool)
    outer[truth.boundary_nodes("skin")] = outer[truth.boundary_nodes("posterior")] = True
    assert not outer.all()
    # Linear fields are in the space of quadratic ones and in equilibrium: exact but for rounding.
    assert carried(truth, np.where(outer[:, None], u, 7.0), outer) == pytest.approx(u, abs=1e-10)


def test_carrying_needs_somewhere_to_carry_from(truth):
    with pytest.raises(MechanicsError, match="no node has a prescribed displacement"):
        carried(truth, np.zeros_like(truth.points), np.zeros(len(truth.points), dtype=bool))
