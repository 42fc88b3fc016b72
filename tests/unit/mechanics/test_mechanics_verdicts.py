"""A solve that finds no equilibrium ends soon, with what it found and why; what nothing holds is named."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import FAT, box

from mammosim.core.errors import MechanicsError, OutOfBudget
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.budget import LEAST_FAILED, Budget, BudgetSpent, Spending
from mammosim.mechanics.compression import Force, Plates, PressSettings, Thickness, compress, continued
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import Settings, equilibrium
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.press_path import WarmStart

TISSUES = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}
NOWHERE = np.zeros((1, 3))


@pytest.fixture(scope="module")
def block():
    return box((3, 2, 3), (30.0, 24.0, 30.0))


def between(mesh):
    points = mesh.points[mesh.points[:, 2] > 12.0]
    return Plates.covering(
        points, direction=np.array([0.0, 1.0, 0.0]), outward=np.array([0.0, 0.0, 1.0]), edge_radius_mm=6.0
    )


def spend(spending, iterations):
    for _ in range(iterations):
        spending.iterate(NOWHERE)


def test_attempts_may_take_twice_what_the_steps_before_took():
    spending = Spending()
    spend(spending, 100)
    spending.succeed()
    spend(spending, 200)
    with pytest.raises(BudgetSpent, match="200 iterations since the last step"):
        spending.iterate(NOWHERE)


def test_a_first_step_has_attempts_of_its_own():
    spending = Spending()
    spend(spending, LEAST_FAILED)
    with pytest.raises(BudgetSpent, match=f"{LEAST_FAILED} iterations since"):
        spending.iterate(NOWHERE)


def test_iterations_and_seconds_in_all_are_bounded():
    few = Spending(Budget(iterations=7))
    spend(few, 7)
    with pytest.raises(BudgetSpent, match="budget of 7 iterations"):
        few.iterate(NOWHERE)
    with pytest.raises(BudgetSpent, match="of a budget of 0 s"):
        Spending(Budget(seconds=0.0), began=-1.0).iterate(NOWHERE)


def test_a_compression_beyond_its_budget_says_how_far_it_came_and_keeps_its_shape(block):
    solver = Settings(newton=NewtonSettings(trusted=0, stagnation=8), budget=Budget(iterations=15))
    with pytest.raises(
        OutOfBudget, match=r"compression to 15 mm stopped at \d\d\.\d+ mm and .* N: the budget"
    ) as out:
        compress(
            block,
            body_effects(block, TISSUES),
            plates=between(block),
            control=Thickness(15.0),
            settings=PressSettings(solver=solver),
        )
    assert out.value.best.shape == block.points.shape
    assert out.value.history


def test_a_load_beyond_its_budget_says_which_part_is_held(block):
    weight = Weight.of(block, TISSUES, np.array([0.0, 0.0, 1.0]))
    with pytest.raises(OutOfBudget, match=r"budget of 1 iterations is spent; .* of load factor 0\.000"):
        equilibrium(
            block,
            body_effects(block, TISSUES),
            loads=(weight,),
            settings=Settings(budget=Budget(iterations=1)),
        )


def test_each_solve_has_a_budget_of_its_own(block):
    """The weight before the plates, the steps, and the proof at the end do not spend each other's."""
    weight = Weight.of(block, TISSUES, np.array([0.0, 0.0, 1.0]))
    settings = PressSettings(steps=2)
    found = compress(
        block, (*body_effects(block, TISSUES), weight), plates=between(block), control=Thickness(20.0),
        settings=settings,
    )  # fmt: skip
    most = int(found.path.iterations.sum())
    solver = replace(settings.solver, budget=Budget(iterations=most))
    again = compress(
        block, (*body_effects(block, TISSUES), weight), plates=between(block), control=Thickness(20.0),
        settings=replace(settings, solver=solver),
    )  # fmt: skip
    assert np.array_equal(again.points, found.points)


def test_trials_for_a_force_are_steps_that_succeeded(block, monkeypatch):
    """A compression that goes on from another has none before its trials, whose iterations add up."""
    monkeypatch.setattr("mammosim.mechanics.budget.LEAST_FAILED", 25)
    body = (block, body_effects(block, TISSUES))
    whole = compress(*body, plates=between(block), control=Thickness(16.0), settings=PressSettings(steps=4))
    starts = [
        WarmStart(
            stage.thickness,
            stage.contacts[0].penalty,
            stage.x,
            np.array([contact.multiplier for contact in stage.contacts]),
        )
        for stage in whole.stages
    ]
    half = float(whole.path.force_n.iloc[-1]) / 2
    found = continued(*body, plates=between(block), control=Force(half), warm_starts=starts)
    assert found.path.force_n.iloc[-1] == pytest.approx(half, rel=1e-4)


@pytest.mark.parametrize(
    ("components", "words"),
    [
        (
            [2],
            r"moving along \(0\.00, 1\.00, 0\.00\) or moving along \(1\.00, 0\.00, 0\.00\) or turning about",
        ),
        ([0, 2], r"against moving along \(0\.00, 1\.00, 0\.00\): hold more"),
    ],
)
def test_a_motion_that_nothing_holds_is_named(block, components, words):
    held = np.zeros(block.points.shape, dtype=bool)
    held[np.ix_(block.boundary_nodes("posterior"), components)] = True
    weight = Weight.of(block, {Label.ADIPOSE: FAT}, np.array([0.0, 0.0, 1.0]))
    with pytest.raises(MechanicsError, match=words):
        equilibrium(block, body_effects(block, TISSUES), loads=(weight,), held=held)


def test_plates_hold_along_the_press_alone_without_friction(block):
    """Along y; it may slide along x, but for friction, and not turn about the plates' normal nor along z."""
    held = np.zeros(block.points.shape, dtype=bool)
    held[block.boundary_nodes("posterior"), 2] = True
    with pytest.raises(MechanicsError, match=r"against moving along \(1\.00, 0\.00, 0\.00\): hold more"):
        compress(
            block, body_effects(block, TISSUES), plates=between(block), control=Thickness(20.0), held=held
        )


def test_a_node_that_is_held_leaves_the_turns_about_it(block):
    held = np.zeros(block.points.shape, dtype=bool)
    held[0] = True
    with pytest.raises(MechanicsError, match="nothing holds the body against turning about"):
        equilibrium(block, body_effects(block, TISSUES), held=held)


def test_three_planes_of_symmetry_hold_a_body(block):
    held = np.isclose(block.points, block.points.min(axis=0))
    weight = Weight.of(block, TISSUES, np.array([0.0, 0.0, 1.0]))
    assert equilibrium(block, body_effects(block, TISSUES), loads=(weight,), held=held).positive_definite
