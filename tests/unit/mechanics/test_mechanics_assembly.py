"""The tangent is assembled into one pattern."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.pattern import Tangent, pattern_of, upper_rows
from mammosim.mechanics.potential import Potential


@pytest.fixture(scope="module")
def mesh():
    return box((3, 3, 3), (10.0, 12.0, 9.0))


@pytest.fixture(scope="module")
def potential(mesh):
    return Potential(body_effects(mesh, {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}, skin=Skin(10.0, 0.45, 1.5)))


def test_gathering_is_the_sum_of_the_element_tangents():
    elements = np.array([[0, 1, 2], [1, 2, 3]])
    Ke = generator("assembly").standard_normal((2, 3, 3, 3, 3))
    K = Tangent.zero(pattern_of(4, [elements]))
    K.add(elements, Ke)
    expected = np.zeros((4, 3, 4, 3))
    for e, nodes in enumerate(elements):
        for a, node in enumerate(nodes):
            for b, other in enumerate(nodes):
                expected[node, :, other] += Ke[e, a, b]
    assert K.to_csr().toarray() == pytest.approx(expected.reshape(12, 12), abs=1e-14)


def test_the_upper_rows_are_the_free_part_of_the_matrix(mesh, potential):
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior"), 1:] = True
    pattern = pattern_of(len(mesh.points), [mesh.cells])
    rows, K = upper_rows(pattern, held), potential.tangent(mesh.points, pattern)
    free = rows.free
    assert np.array_equal(np.sort(free), np.flatnonzero(~held.ravel()))
    expected = np.triu(K.to_csr().toarray()[np.ix_(free, free)])
    found = np.zeros_like(expected)
    for i in range(len(free)):
        span = slice(rows.row_start[i], rows.row_start[i + 1])
        found[i, rows.columns[span]] = rows.values(K)[span]
    assert np.array_equal(found, expected)
