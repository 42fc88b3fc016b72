"""What every effect must satisfy: its gradient and tangent are derivatives of its energy."""

import numpy as np
import pytest

from mammosim.core.rng import generator
from mammosim.mechanics.pattern import Tangent, pattern_of


def gradient(effect, x):
    g = np.zeros_like(x)
    effect.add_gradient(x, g)
    return g


def tangent(effect, x, **options):
    """The tangent (3 n_node, 3 n_node) as a sparse matrix."""
    K = Tangent.zero(pattern_of(len(x), [effect.connectivity]))
    effect.add_tangent(x, K, **options)
    return K.to_csr()


def assert_derives_from_its_energy(effect, x):
    """Central differences of energy and gradient along a fixed direction."""
    v = generator("direction").standard_normal(x.shape)
    # Truncation h^2, rounding 1e-16 / h; points that cross a kink of the second derivative leave an error
    # of order h.
    h = 1e-5
    difference = (effect.energy(x + h * v) - effect.energy(x - h * v)) / (2 * h)
    assert np.sum(gradient(effect, x) * v) == pytest.approx(difference, rel=1e-6)
    h = 1e-6
    difference = (gradient(effect, x + h * v) - gradient(effect, x - h * v)) / (2 * h)
    product = (tangent(effect, x) @ v.ravel()).reshape(x.shape)
    assert np.any(difference) == (len(effect.connectivity) > 0)
    assert np.abs(product - difference).max() <= 1e-6 * np.abs(difference).max()


def assert_symmetric_and_projectable(effect, x):
    """The tangent is symmetric to the last bit; projected, it has no negative eigenvalue beyond rounding."""
    K = tangent(effect, x)
    assert abs(K - K.T).max() == 0.0
    values = np.linalg.eigvalsh(tangent(effect, x, projected=True).toarray())
    assert values[-1] > 0
    assert values[0] >= -1e-12 * values[-1]


def assert_rotation_stores_nothing(effect, points, turn):
    """Rigid motion of the reference; turn (3, 3)."""
    x = points @ turn.T + [3.0, 4.0, 5.0]
    assert abs(effect.energy(x)) <= 1e-10
    assert np.abs(gradient(effect, x)).max() <= 1e-10
