"""Solves that share one symbolic analysis give the answers of solves that do not."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics import linear
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.body import Skin, load

DOWN = np.array([0.0, 0.0, 1.0])
MODULI = (2.0, 1.0, 0.5)


@pytest.fixture
def analyses(monkeypatch):
    """The sizes of the matrices that were analysed."""
    sizes, made = [], linear._factors

    def counted(upper):
        factors = made(upper)
        analyse = factors.analyse

        def counting():
            sizes.append(upper.shape[0])
            analyse()

        factors.analyse = counting
        return factors

    monkeypatch.setattr(linear, "_factors", counted)
    return sizes


def sweep(mesh, **options):
    return [load(mesh, {Label.ADIPOSE: Tissue(E, 0.45, 1.0)}, DOWN, **options) for E in MODULI]


def test_a_sweep_is_analysed_once_and_gives_the_same_shapes(analyses):
    mesh = box((2, 2, 2), (40.0, 40.0, 40.0))
    apart = sweep(mesh)
    assert len(analyses) == len(MODULI)
    with shared_analysis():
        together = sweep(mesh)
    assert len(analyses) == len(MODULI) + 1
    for one, other in zip(apart, together):
        assert np.array_equal(one.points, other.points)


def test_a_membrane_more_is_another_analysis(analyses):
    mesh = box((2, 2, 2), (40.0, 40.0, 40.0))
    with shared_analysis():
        sweep(mesh)
        sweep(mesh, skin=Skin(10.0, 0.45, 1.5))
        sweep(mesh.moved_to(1.1 * mesh.points))
    assert len(analyses) == 2


def test_another_law_of_the_bulk_is_another_analysis():
    """Near incompressibility pressures are unknowns, too: other matrices on the same cells."""
    mesh = box((2, 2, 2), (40.0, 40.0, 40.0))
    tissues = [{Label.ADIPOSE: Tissue(1.0, nu, 1.0)} for nu in (0.45, 0.495, 0.45)]
    with shared_analysis():
        together = [load(mesh, tissue, DOWN).points for tissue in tissues]
    apart = load(mesh, tissues[1], DOWN).points
    assert np.array_equal(together[1], apart)
    assert np.array_equal(together[0], together[2])


def test_outside_nothing_is_kept(analyses):
    mesh = box((1, 1, 1), (40.0, 40.0, 40.0))
    with shared_analysis(), shared_analysis():
        sweep(mesh)
    sweep(mesh)
    assert len(analyses) == 1 + len(MODULI)
