"""Methods are compared where the stress-free shape is known; what fails is an outcome with its reason."""

import math

import numpy as np
import pytest

from mammosim.chain.outcome import CONVERGED
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body
from mammosim.mechanics.unloading import METHODS
from mammosim.meshing.shapes import box
from mammosim.study.unloading import Case, rows, soft

HANGING = np.array([0.0, 0.0, 1.0])


def block(density):
    body = Body({Label.ADIPOSE: Tissue(1.0, 0.45, density)})
    return Case(box((2, 2, 2), (50.0, 50.0, 50.0)), body, HANGING)


def test_every_iterated_method_finds_what_it_was_loaded_from():
    table = {row["method"]: row for row in rows(block(0.4))}
    assert list(table) == list(METHODS)
    assert {row["outcome"] for row in table.values()} == {CONVERGED}
    # Errors of the shape are of the size of the tolerance; that of reverse gravity is of second order.
    iterated = [row for name, row in table.items() if name != "reverse_gravity"]
    assert max(row["error_mean_mm"] for row in iterated) < 0.05 < table["reverse_gravity"]["error_mean_mm"]
    assert all(row["iterations"] >= 1 and row["forward_solves"] > 0 for row in iterated)


def test_a_body_without_a_prone_state_fails_with_every_method():
    table = rows(block(8.0), methods=("fixed_point", "anderson"))
    assert [row["method"] for row in table] == ["fixed_point", "anderson"]
    for row in table:
        assert row["outcome"].partition(": ")[2].startswith("no stable prone state: ")
        assert row["outcome"].startswith(("failed: ", "unstable: "))
        assert math.isnan(row["error_mean_mm"])


def test_without_a_supine_state_only_the_mean_is_missing():
    """A tall block hangs in peace and buckles when it stands."""
    body = Body({Label.ADIPOSE: Tissue(1.0, 0.45, 0.5)})
    slender = Case(box((1, 1, 4), (15.0, 15.0, 60.0)), body, HANGING)
    mean, plain = rows(slender, methods=("mean_start", "anderson"))
    assert mean["outcome"].partition(": ")[2].startswith("no stable supine state for the mean: ")
    assert plain["outcome"] == CONVERGED


def test_one_modulus_is_that_of_fat_and_gland_alone():
    tissues = {label: Tissue(2.0, 0.45, 1.0) for label in (Label.ADIPOSE, Label.GLANDULAR, Label.MUSCLE)}
    changed = soft(tissues, 0.5)
    assert [changed[label].youngs_modulus_kpa for label in tissues] == pytest.approx([0.5, 0.5, 2.0])
