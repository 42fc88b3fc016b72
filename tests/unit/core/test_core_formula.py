"""Formulas mean what they say, and nothing beside them can be written."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.formula import Formula

U, V = np.array([1.0, 2.0, 4.0]), np.array([-3.0, 0.5, 2.0])


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("u**2 / 4 - v", U**2 / 4 - V),
        ("-(u + 2) * v", -(U + 2) * V),
        ("3 * exp(-u / 2) + abs(v)", 3 * np.exp(-U / 2) + np.abs(V)),
        ("sqrt(u) * sin(pi * v)", np.sqrt(U) * np.sin(np.pi * V)),
        ("7", 7.0),
    ],
)
def test_a_formula_means_what_it_says(text, meant):
    np.testing.assert_allclose(Formula.read(text, ("u", "v"))({"u": U, "v": V}), meant)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is no formula of 1 to 500 characters"),
        ("u +", "is no formula: invalid syntax; write it as `u\\*\\*2 / 400`"),
        ("w", r"'w' is not understood; a formula has u, v, pi, numbers, \+ - \* / \*\*, brackets, sqrt"),
        ("u.real", r"'u\.real' is not understood"),
        ("__import__('os')", "is not understood"),
        ("exp(u, v)", "is not understood"),
        ("u if v else 1", "is not understood"),
        ("True", "is not understood"),
    ],
)
def test_what_is_no_formula_is_rejected(text, words):
    with pytest.raises(ConfigurationError, match=words):
        Formula.read(text, ("u", "v"))
