"""A body that is too heavy for its moduli: what is tried for its stress-free shape, and what is not."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import FAT, HANGING, LIGHT

from mammosim.core.errors import EquilibriumError, MechanicsError, UnloadingError
from mammosim.core.labels import Label
from mammosim.core.tissues import CellTissues
from mammosim.mechanics.body import Body, Fascia, Ligaments, Skin
from mammosim.mechanics.unloaded import Unloaded, UnloadingSettings
from mammosim.mechanics.unloading import METHODS
from mammosim.mechanics.unloading_order import Attempt, Order, least_factor, reloaded_mm

BODY = LIGHT


def of_density(density):
    return Body({Label.ADIPOSE: replace(FAT, density_g_cm3=density)})


@pytest.fixture
def asked(monkeypatch):
    """What methods are asked for, `method E`; those whose answer is an error fail by it."""
    answers, found = {}, []

    def set_to(**given):
        answers.update(given)
        monkeypatch.setattr(
            "mammosim.mechanics.unloading_order.METHODS", {name: method(name) for name in answers}
        )
        return found

    def method(name):
        def unload(measured, body, *, gravity, settings):
            (tissue,) = body.tissues.values()
            found.append((name, tissue.youngs_modulus_kpa))
            answer = answers[name](tissue.youngs_modulus_kpa)
            if isinstance(answer, Exception):
                raise answer
            return Unloaded(answer)

        return unload

    return set_to


def test_with_all_moduli_times_a_factor_a_body_hangs_as_under_its_weight_over_the_factor(truth):
    parts = (Skin(10.0, 0.45, 1.5),)
    stiff = Body({Label.ADIPOSE: FAT}, parts).stiffened(2.5)
    light = Body({Label.ADIPOSE: replace(FAT, density_g_cm3=FAT.density_g_cm3 / 2.5)}, parts)
    one, other = (body.load(truth, HANGING).points for body in (stiff, light))
    np.testing.assert_allclose(one, other, atol=1e-6)


def test_every_part_and_every_cell_is_stiffened_and_nothing_else():
    cells = CellTissues(np.array([1.0, 2.0]), np.array([0.4, 0.3]), np.array([1.0, 0.9]))
    body = Body(cells, (Skin(10.0, 0.45, 1.5), Fascia(120.0, 0.45, 0.1), Ligaments(1.0, 2.0))).stiffened(3.0)
    assert body.parts == (Skin(30.0, 0.45, 1.5), Fascia(360.0, 0.45, 0.1), Ligaments(3.0, 2.0))
    np.testing.assert_array_equal(body.tissues.youngs_modulus_kpa, [3.0, 6.0])
    np.testing.assert_array_equal(body.tissues.density_g_cm3, cells.density_g_cm3)


def test_the_second_method_is_taken_where_the_first_finds_nothing_and_says_so(truth, measured, asked):
    found = asked(first=lambda E: MechanicsError("diverges"), second=lambda E: truth.points)
    got = Order(("first", "second"), (2.0,)).unload(measured, BODY, gravity=HANGING)
    assert found == [("first", 1.0), ("second", 1.0)]
    assert [(each.method, each.moduli_factor) for each in got.attempts] == found
    assert str(got.attempts[0].failure) == "diverges"
    assert got.attempts[1].failure is None
    # The solver's own tolerance of 1e-8 of the load.
    assert got.attempts[1].largest_mm < 1e-5


def test_the_softest_factor_that_carries_the_weight_is_taken(truth, measured, asked):
    """The measured shape is that of 1 kPa, so what stiffer moduli need is found by the method itself."""

    def stiff(E):
        if E < 3.0:
            return EquilibriumError("too soft")
        return METHODS["anderson"](measured, BODY.stiffened(E), gravity=HANGING).points

    found = asked(only=stiff)
    got = Order(("only",), (5.0, 3.0, 2.0)).unload(measured, BODY, gravity=HANGING)
    assert [E for _, E in found] == [1.0, 2.0, 3.0], "the smallest first, and none after one that carries"
    assert got.attempts[-1].moduli_factor == 3.0
    again = BODY.stiffened(3.0).load(measured.moved_to(got.points), HANGING).points
    assert np.linalg.norm(again - measured.points, axis=1).max() <= UnloadingSettings().tolerance_mm


def test_a_shape_that_does_not_come_back_to_the_measured_one_does_not_count(truth, measured, asked):
    asked(wrong=lambda E: measured.points, right=lambda E: truth.points)
    got = Order(("wrong", "right")).unload(measured, BODY, gravity=HANGING)
    wrong = got.attempts[0]
    away = np.linalg.norm(BODY.load(measured, HANGING).points - measured.points, axis=1).max()
    assert wrong.largest_mm == pytest.approx(away)
    assert "loaded again it lies up to" in str(wrong.failure)


def test_factors_that_the_weight_is_known_to_be_too_much_for_are_not_tried(truth, measured, asked):
    """Only 0.45 of the weight was brought on, so that 2.2 times the moduli are needed."""
    failed = UnloadingError("no step", load_factor=0.45)
    found = asked(first=lambda E: MechanicsError("diverges"), by_steps=lambda E: failed)
    with pytest.raises(MechanicsError) as caught:
        Order(("first", "by_steps"), (1.5, 2.0)).unload(measured, BODY, gravity=HANGING)
    assert [E for _, E in found] == [1.0, 1.0]
    words = str(caught.value)
    assert "by first or by_steps with all moduli times 1; 2.22 would be needed" in words
    assert "\n" not in words


def test_what_was_carried_of_the_weight_counts_by_its_factor():
    failed = UnloadingError("no step", load_factor=0.8)
    assert least_factor([Attempt("inverse", 2.0, failure=failed)]) == pytest.approx(2.5)
    nothing = UnloadingError("no step", load_factor=0.0)
    assert least_factor([Attempt("inverse", 2.0, failure=nothing)]) == np.inf
    assert least_factor([Attempt("anderson", 2.0, failure=MechanicsError("diverges"))]) == 0.0


def test_what_failed_before_is_told_and_not_tried_again(truth, measured, asked):
    found = asked(first=lambda E: MechanicsError("again"), second=lambda E: truth.points)
    before = [Attempt("first", 1.0, failure=MechanicsError("before"))]
    got = Order(("first", "second"), attempts=before).unload(measured, BODY, gravity=HANGING)
    assert found == [("second", 1.0)]
    assert [str(each.failure) for each in got.attempts] == ["before", "None"]


def test_the_part_of_the_weight_that_newton_brought_on_is_told_and_carries(truth):
    """A block that hangs as measured of 2 kPa is to hang so of moduli that are too soft for it."""
    measured = truth.moved_to(of_density(1.0).stiffened(2.0).load(truth, HANGING).points)
    soft = of_density(12.0)
    with pytest.raises(UnloadingError) as caught:
        METHODS["inverse"](measured, soft, gravity=HANGING)
    w = caught.value.load_factor
    assert 0 < w < 1
    rest = METHODS["inverse"](measured, soft.stiffened(1 / w), gravity=HANGING).points
    assert reloaded_mm(rest, measured, soft.stiffened(1 / w), HANGING) <= UnloadingSettings().tolerance_mm
