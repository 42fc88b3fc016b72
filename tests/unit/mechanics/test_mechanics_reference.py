"""The elements of scikit-fem have the nodes, shape functions and quadrature that the mechanics counts on."""

import subprocess
import sys
from itertools import product
from math import factorial

import numpy as np
import pytest

from mammosim.core.mesh import EDGES
from mammosim.core.rng import generator
from mammosim.mechanics.reference import (
    TETRAHEDRON,
    TETRAHEDRON_POINTS,
    TETRAHEDRON_WEIGHTS,
    TRIANGLE,
    TRIANGLE_POINTS,
    TRIANGLE_WEIGHTS,
    shape_functions,
    shape_gradients,
)

TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
ELEMENTS = [(TETRAHEDRON, EDGES), (TRIANGLE, TRIANGLE_EDGES)]
ROUNDING = 4e-15  # of some ten products of numbers up to 4


@pytest.mark.parametrize(("element", "edges"), ELEMENTS)
def test_shape_functions_are_those_of_vtk_order(element, edges):
    """Vertices L_a (2 L_a - 1), then edges 4 L_a L_b."""
    n_vertex = len(element.refdom.p) + 1
    L = generator("points of an element").dirichlet(np.ones(n_vertex), 50)
    N = np.hstack([L * (2 * L - 1), np.column_stack([4 * L[:, a] * L[:, b] for a, b in edges])])
    assert np.abs(shape_functions(L, element) - N).max() < ROUNDING


@pytest.mark.parametrize(("element", "edges"), ELEMENTS)
def test_gradients_are_those_of_vtk_order(element, edges):
    """dN/dxi with L_0 = 1 - sum xi: (4 L_a - 1) dL_a, then 4 (L_a dL_b + L_b dL_a)."""
    n_vertex = len(element.refdom.p) + 1
    L = generator("points of an element").dirichlet(np.ones(n_vertex), 50)
    dL = np.vstack([-np.ones(n_vertex - 1), np.eye(n_vertex - 1)])
    vertices = [(4 * L[:, a, None] - 1) * dL[a] for a in range(n_vertex)]
    between = [4 * (L[:, a, None] * dL[b] + L[:, b, None] * dL[a]) for a, b in edges]
    assert np.abs(shape_gradients(L, element) - np.stack(vertices + between, axis=1)).max() < ROUNDING


@pytest.mark.parametrize(
    ("L", "weights", "degree"),
    [(TETRAHEDRON_POINTS, TETRAHEDRON_WEIGHTS, 2), (TRIANGLE_POINTS, TRIANGLE_WEIGHTS, 4)],
)
def test_quadrature_is_exact_to_its_degree_and_no_further(L, weights, degree):
    """The integral of L_0^i L_1^j ... is i! j! ... / (i + j + ... + dim)!."""

    def worst(total: int) -> float:
        powers = [p for p in product(range(total + 1), repeat=L.shape[1]) if sum(p) == total]
        exact = [np.prod([factorial(i) for i in p]) / factorial(total + L.shape[1] - 1) for p in powers]
        return max(abs(weights @ np.prod(L**p, axis=1) - e) for p, e in zip(powers, exact))

    assert max(worst(total) for total in range(degree + 1)) < ROUNDING
    assert worst(degree + 1) > 1e-4


def test_the_points_are_those_of_keast_and_of_dunavant():
    """Four near the vertices of a tetrahedron; three near vertices, three near edges of a triangle."""
    a, b = (5 + 3 * np.sqrt(5)) / 20, (5 - np.sqrt(5)) / 20
    assert np.sort(TETRAHEDRON_POINTS, axis=1) == pytest.approx(np.tile([b, b, b, a], (4, 1)), abs=ROUNDING)
    assert np.sort(TETRAHEDRON_POINTS.argmax(axis=1)).tolist() == [0, 1, 2, 3]
    assert np.sort(TRIANGLE_WEIGHTS) == pytest.approx(
        [0.109951743655322 / 2] * 3 + [0.223381589678011 / 2] * 3, abs=ROUNDING
    )
    for s, weight in ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)):
        of_orbit = TRIANGLE_POINTS[np.isclose(TRIANGLE_WEIGHTS, weight / 2)]
        assert np.sort(of_orbit.ravel()) == pytest.approx(np.sort([1 - 2 * s, s, s] * 3), abs=ROUNDING)


def test_what_only_names_the_stages_does_not_wait_for_scikit_fem():
    text = (
        "import sys, mammosim, mammosim.chain.stages, mammosim.chain.files; sys.exit('skfem' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", text], check=False).returncode == 0
