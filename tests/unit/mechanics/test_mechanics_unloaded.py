"""The stress-free shape, loaded again, is the measured one."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import load
from mammosim.mechanics.elastic import carried
from mammosim.mechanics.unloaded import FixedPointSettings, fixed_point, reverse_gravity

# Light enough that the block, 50 mm tall, stretches by a tenth and does not buckle under reversed gravity.
TISSUES = {Label.ADIPOSE: Tissue(1.0, 0.45, 0.4)}
HANGING = np.array([0.0, 0.0, 1.0])


def under_gravity(mesh, gravity, start):
    return load(mesh, TISSUES, gravity, start=start)


@pytest.fixture(scope="module")
def truth():
    return box((2, 2, 2), (50.0, 50.0, 50.0))


@pytest.fixture(scope="module")
def measured(truth):
    return truth.moved_to(under_gravity(truth, HANGING, None).points)


def test_the_fixed_point_finds_the_skin_of_the_true_shape(truth, measured):
    settings = FixedPointSettings(tolerance_mm=0.01)
    found = fixed_point(measured, under_gravity, gravity=HANGING, settings=settings)
    assert found.history[-1].mean_mm <= 0.01
    skin = measured.boundary_nodes("skin")
    distance = np.linalg.norm((found.points - truth.points)[skin], axis=1)
    # The load stretches this body by a tenth, so errors of the shapes are of the size of the residual.
    assert distance.mean() <= 2 * 0.01
    assert [row.iteration for row in found.history] == list(range(len(found.history)))


def test_the_residual_falls_at_every_iteration(measured):
    found = fixed_point(measured, under_gravity, gravity=HANGING)
    assert np.all(np.diff([row.mean_mm for row in found.history]) < 0)


def test_reverse_gravity_is_near_for_small_strain_and_far_for_large(truth):
    """Its error is of second order: twice the gravity leaves about 4 times the error."""
    errors = []
    for density in (0.1, 0.2):
        tissues = {Label.ADIPOSE: Tissue(1.0, 0.45, density)}

        def under(mesh, gravity, start, tissues=tissues):
            return load(mesh, tissues, gravity, start=start)

        measured = truth.moved_to(under(truth, HANGING, None).points)
        found = reverse_gravity(measured, under, gravity=HANGING)
        errors.append(np.linalg.norm(found.points - truth.points, axis=1).mean())
    assert errors[1] / errors[0] == pytest.approx(4.0, rel=0.15)


def test_a_better_start_needs_fewer_iterations(truth, measured):
    cold = fixed_point(measured, under_gravity, gravity=HANGING)
    warm = fixed_point(measured, under_gravity, gravity=HANGING, start=truth.points)
    # The truth's skin loads to the measured one, to the solver's tolerance.
    assert len(warm.history) == 1 < len(cold.history)


def test_a_fixed_point_that_is_not_reached_is_refused(measured):
    settings = FixedPointSettings(tolerance_mm=1e-6, max_iterations=2)
    with pytest.raises(MechanicsError, match="2 fixed-point iterations left a mean"):
        fixed_point(measured, under_gravity, gravity=HANGING, settings=settings)


def test_divergence_is_refused_with_its_reason(measured):
    def failing(mesh, gravity, start):
        if start is not None:
            raise EquilibriumError("lost")
        return under_gravity(mesh, gravity, start)

    with pytest.raises(MechanicsError, match=r"diverges at a mean of .* has no equilibrium"):
        fixed_point(measured, failing, gravity=HANGING)


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
