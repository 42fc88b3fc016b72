"""Bodies, scenes and twins of the hard cases: what is spoilt is spoilt, what should be equal is."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jv

from mammosim.core.errors import MammosimError
from mammosim.meshing.quality import quality
from mammosim.study.hard_cases.bodies import DEFECTS, body
from mammosim.study.hard_cases.references import greenhill, laminate, reference
from mammosim.study.hard_cases.scenes import scene
from mammosim.study.hard_cases.twins import TWINS, shape_of, twin

BALL = {"shape": "ball", "radius_mm": 60.0, "edge_mm": 25.0}
SCENE = {
    "body": BALL,
    "tissues": {"adipose": {"youngs_modulus_kpa": 3.0, "poisson_ratio": 0.45, "density_g_cm3": 1.0}},
    "gravity": [0.6, 0.0, 0.8],
    "skin": {"youngs_modulus_kpa": 10.0, "poisson_ratio": 0.45, "thickness_mm": 1.0},
    "wall": {"shape": "plane"},
    "contact_kpa_mm": 5.0,
}
CHANGES = {
    "turned": {"degrees": [20, 40, -70]},
    "shifted": {"mm": [100, 0, -50]},
    "scaled": {"length": 3.0, "stiffness": 7.0},
    "renumbered": {"seed": 3},
    "stepwise": {"load_steps": 2},
    "by_way_of": {"gravity": [[0, 0, 1]]},
}


def test_squeezed_elements_are_slivers_and_nothing_is_inverted():
    mesh = body(**{**BALL, "edge_mm": 15.0}, slivers={"count": 5, "height": 0.008})
    table = quality(mesh)
    assert (table.aspect_ratio > 50).sum() >= 5
    assert table.smallest_J.min() > 0
    assert table.volume_mm3.sum() == pytest.approx(2 / 3 * np.pi * 60**3, rel=1e-3)


@pytest.mark.parametrize("defect", DEFECTS)
def test_every_defect_is_refused(defect):
    with pytest.raises(MammosimError):
        scene({**SCENE, "body": {**BALL, "edge_mm": 15.0, "defect": defect}}).equilibrium()


def test_a_layer_lies_inside_the_radius_and_is_of_skin():
    mesh = body(**BALL, layer_mm=2.0)
    assert np.linalg.norm(mesh.points, axis=1).max() == pytest.approx(60.0)
    assert set(np.unique(mesh.tissue)) == {1, 3}


@pytest.fixture(scope="module")
def there():
    found = scene(SCENE)
    return found, found.equilibrium().points


@pytest.mark.parametrize("name", TWINS)
def test_a_twin_has_the_same_answer(there, name):
    found, x = there
    other = shape_of(twin(found, {name: CHANGES[name]}))
    assert np.abs(other - x).max() <= 1e-6 * np.abs(x - found.mesh.points).max()


def test_changes_add_up(there):
    found, x = there
    both = twin(found, {name: CHANGES[name] for name in ("scaled", "renumbered", "turned", "shifted")})
    assert np.abs(shape_of(both) - x).max() <= 1e-6 * np.abs(x - found.mesh.points).max()


def test_a_layer_stretched_alone_thins_as_small_strain_has_it():
    """Plane strain: e_z = - nu / (1 - nu) e_x."""
    layer = {"thickness_mm": 2.0, "youngs_modulus_kpa": 5.0, "poisson_ratio": 0.45}
    thinned = laminate(stretch=1 + 1e-5, layers=[layer])
    assert thinned == pytest.approx(-2.0 * 1e-5 * 0.45 / 0.55, rel=1e-4)


def test_the_column_bends_at_the_first_zero_of_the_bessel_function():

    zero = brentq(lambda z: jv(-1 / 3, z), 1.5, 2.5)
    factor = greenhill(youngs_modulus_kpa=1.0, density_g_cm3=1.0, height_mm=10.0, side_mm=1.0)
    assert factor == pytest.approx(9 / 4 * zero**2 / (12 * 9.81e-3 * 1000), rel=1e-4)


def test_references_come_from_their_tables():
    assert reference({"hemisphere": {"case": "E1_nu0.45"}}) == 13.4175
    assert reference({"column": {"nu": 0.45, "q": 0.5, "direction": "hang"}}) == 0.0228217272
