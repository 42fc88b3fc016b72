"""What is left of the tangent of the bulk law is its positive part, by the eigenvalues of d2W/dF2 (9 x 9)."""

import numpy as np
import pytest
from scipy.stats import special_ortho_group

from mammosim.mechanics.effects.bulk_kernels import tangents
from mammosim.mechanics.effects.bulk_projection import project_tangents

EPSILON = np.zeros((3, 3, 3))
for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    EPSILON[i, j, k], EPSILON[i, k, j] = 1.0, -1.0
CELLS = np.arange(10)[None]
WEIGHTS = np.array([[0.4, 0.8, 1.2, 0.6]])


def second_derivative(F: np.ndarray, mu: float, k: float, p: float) -> np.ndarray:
    """d2W/dF2 (9, 9) of effects.bulk, with the pressure p."""
    J, I1 = np.linalg.det(F), np.sum(F * F)
    C = J * np.linalg.inv(F).T
    f, c, m = F.ravel(), C.ravel(), mu * J ** (-2 / 3)
    d2J = np.einsum("ijk,abc,kc->iajb", EPSILON, EPSILON, F).reshape(9, 9)
    mixed = -2 / 3 * m / J * (np.outer(f, c) + np.outer(c, f))
    return m * np.eye(9) + mixed + (5 / 9 * m / J**2 * I1 + k) * np.outer(c, c) + (p - m / (3 * J) * I1) * d2J


def element(F: np.ndarray, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Positions (10, 3) and gradients (1, 4, 10, 3) at four equal points, at which the deformation is F."""
    g = np.random.default_rng(seed).normal(size=(10, 3))
    return g @ np.linalg.solve(g.T @ g, F.T), np.broadcast_to(g, (1, 4, 10, 3)).copy()


def projected(F: np.ndarray, mu: float, k: float, p: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The tangent (30, 30) of an element, what is left of it, and what eigenvalues of d2W/dF2 say is left."""
    x, dN = element(F)
    law = np.array([mu]), np.array([k]), np.full((1, 4), p)
    Ke = tangents(x, CELLS, dN, WEIGHTS, *law)
    left = Ke.copy()
    project_tangents(left, x, CELLS, dN, WEIGHTS, *law)
    values, vectors = np.linalg.eigh(second_derivative(F, mu, k, p))
    A = (vectors * np.maximum(values, 0)) @ vectors.T
    expected = WEIGHTS.sum() * np.einsum("aA,iAjB,bB->abij", dN[0, 0], A.reshape(3, 3, 3, 3), dN[0, 0])
    return Ke[0], left[0], expected


RANDOM = [
    (rotation @ np.diag(stretches) @ other.T, mu, k, p)
    for rotation, other, stretches, mu, k, p in zip(
        special_ortho_group.rvs(3, 40, random_state=1),
        special_ortho_group.rvs(3, 40, random_state=2),
        np.exp(np.random.default_rng(3).normal(scale=0.7, size=(40, 3))),
        np.random.default_rng(4).uniform(0.1, 10, 40),
        10 ** np.random.default_rng(5).uniform(0, 4, 40),
        np.random.default_rng(6).normal(scale=20, size=40),
    )
]
SPECIAL = [
    (np.eye(3), 1.0, 10.0, 0.0),
    (np.eye(3), 1.0, 10.0, 5.0),
    (np.diag([0.5, 0.5, 0.5]), 1.0, 10.0, -5.0),
    (np.diag([0.3, 1.2, 1.2]), 0.3, 100.0, -3.0),
    (np.diag([2.0, 2.0, 0.25]), 0.3, 3.0, 4.0),
    (np.diag([0.01, 1.0, 3.0]), 1.0, 10.0, -1.0),
    (np.diag([-1.0, -1.0, 1.0]) * 1.1, 1.0, 10.0, 1.0),
    (np.eye(3) + np.array([[0.0, 1.5, 0.0]] + [[0.0] * 3] * 2), 1.0, 1000.0, 2.0),
]


@pytest.mark.parametrize(("F", "mu", "k", "p"), [*SPECIAL, *RANDOM])
def test_what_is_left_is_the_positive_part(F, mu, k, p):
    _, left, expected = projected(F, mu, k, p)
    assert np.abs(left - expected).max() <= 1e-10 * np.abs(expected).max()
    assert np.array_equal(left, left.transpose(1, 0, 3, 2)), "symmetric to the last bit"


def test_the_random_ones_have_from_none_to_many_negative_directions():
    negative = [(np.linalg.eigvalsh(second_derivative(*each)) < 0).sum() for each in RANDOM]
    assert min(negative) == 0
    assert max(negative) >= 4


def test_a_tangent_that_is_positive_stays_as_it_is():
    Ke, left, _ = projected(np.diag([1.01, 0.99, 1.0]), 1.0, 10.0, 0.5)
    assert np.array_equal(Ke, left)


def test_the_second_derivative_here_is_that_of_the_kernel():
    """Without negative directions the tangent itself is what the formula gives."""
    Ke, _, expected = projected(np.eye(3) + 0.05 * np.arange(9).reshape(3, 3) / 9, 1.0, 20.0, 0.5)
    assert np.abs(Ke - expected).max() <= 1e-12 * np.abs(Ke).max()
