"""A cell of several tissues: what its modulus, nu and density are."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.mixture import cell_tissues, mixed_modulus
from mammosim.meshing.shapes import box

E = np.array([0.8, 2.0, 25.0])  # fat, gland, muscle
MUSCLE = np.array([False, False, True])
TISSUES = {
    Label.ADIPOSE: Tissue(0.8, 0.48, 0.95),
    Label.GLANDULAR: Tissue(2.0, 0.48, 1.02),
    Label.MUSCLE: Tissue(25.0, 0.48, 1.05),
}
HALF_AND_HALF = {Label.ADIPOSE: 0.5, Label.GLANDULAR: 0.5}


@pytest.fixture
def shares():
    """Shares (500, 3) of random cells."""
    return np.random.default_rng(1).dirichlet([0.7, 0.7, 0.7], size=500)


def of_shares(shares_by_label):
    """A block all of whose cells have these shares."""
    block = box((2, 2, 2), (10.0, 10.0, 10.0))
    row = np.zeros(len(Label))
    row[list(shares_by_label)] = list(shares_by_label.values())
    n = len(block.cells)
    return replace(block, tissue=np.full(n, row.argmax()), shares=np.tile(row, (n, 1)))


def test_a_cell_of_one_tissue_has_its_modulus():
    np.testing.assert_allclose(mixed_modulus(np.eye(3), E, MUSCLE), E, rtol=1e-15)


def test_half_fat_and_half_gland_have_the_geometric_mean():
    # E_V E_R = (a + b) / 2 * 2 a b / (a + b) = a b
    assert mixed_modulus(np.array([[0.5, 0.5, 0.0]]), E, MUSCLE) == pytest.approx(np.sqrt(0.8 * 2.0))


def test_muscle_is_in_series_with_the_rest():
    half = mixed_modulus(np.array([[0.5, 0.0, 0.5], [0.25, 0.25, 0.5]]), E, MUSCLE)
    rest = np.array([0.8, np.sqrt(0.8 * 2.0)])
    assert half == pytest.approx(2 * rest * 25.0 / (rest + 25.0))


def test_the_modulus_lies_between_the_bounds_of_voigt_and_reuss(shares):
    mixed = mixed_modulus(shares, E, MUSCLE)
    assert np.all(mixed <= shares @ E * (1 + 1e-12))
    assert np.all(mixed >= 1 / (shares @ (1 / E)) * (1 - 1e-12))


def test_tissues_of_one_modulus_mix_to_it_and_twice_the_moduli_to_twice_as_much(shares):
    np.testing.assert_allclose(mixed_modulus(shares, np.full(3, 1.7), MUSCLE), 1.7, rtol=1e-12)
    np.testing.assert_allclose(mixed_modulus(shares, 2 * E, MUSCLE), 2 * mixed_modulus(shares, E, MUSCLE))


def test_a_mixed_block_weighs_what_its_tissues_weigh():
    mesh, down = of_shares(HALF_AND_HALF), np.array([0.0, 0.0, -1.0])
    weights = {label: Weight.of(of_shares({label: 1.0}), TISSUES, down).forces for label in HALF_AND_HALF}
    mean = (weights[Label.ADIPOSE] + weights[Label.GLANDULAR]) / 2
    np.testing.assert_allclose(Weight.of(mesh, TISSUES, down).forces, mean, atol=1e-12)


def test_nu_is_the_mean_by_volume():
    tissues = TISSUES | {Label.GLANDULAR: Tissue(2.0, 0.42, 1.02)}
    assert cell_tissues(of_shares(HALF_AND_HALF), tissues).poisson_ratio == pytest.approx(0.45)


def test_a_tissue_that_no_cell_has_most_of_needs_parameters_too():
    mesh = of_shares({Label.ADIPOSE: 0.9, Label.LESION: 0.1})
    with pytest.raises(MechanicsError, match="'lesion' is in the mesh but has no parameters"):
        cell_tissues(mesh, TISSUES)
