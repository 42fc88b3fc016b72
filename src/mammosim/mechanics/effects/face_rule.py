"""Quadrature on quadratic triangles that follows the border of a contact: the six points, or finer.

The integrand of contact has a kink where contact begins, so that more points help, a higher degree does not.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.reference import (
    TRIANGLE,
    TRIANGLE_POINTS,
    TRIANGLE_WEIGHTS,
    shape_functions,
    shape_gradients,
)


@dataclass(frozen=True)
class FaceRule:
    """Barycentric points L (n_q, 3) with weights (n_q,), which sum to the triangle's area 1/2."""

    points: np.ndarray
    weights: np.ndarray

    @cached_property
    def shapes(self) -> np.ndarray:
        """N (n_q, 6)."""
        return shape_functions(self.points, TRIANGLE)

    @cached_property
    def gradients(self) -> np.ndarray:
        """dN/dxi (n_q, 6, 2)."""
        return shape_gradients(self.points, TRIANGLE)

    def areas(self, x: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Area (n_face, n_q) mm2 that each point stands for, of faces (n_face, 6) in x (n_node, 3)."""
        tangents = np.einsum("eai,qaj->eqij", x[faces], self.gradients)
        areas: np.ndarray = (
            np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1) * self.weights
        )
        return areas


SIX_POINTS = FaceRule(TRIANGLE_POINTS, TRIANGLE_WEIGHTS)


def six_points_in_each(parts: int) -> FaceRule:
    """The six points in each of parts^2 equal triangles. Raises MechanicsError unless parts >= 1."""
    if parts < 1:
        raise MechanicsError(f"a face is cut into {parts} parts along its edges; it must be at least 1")
    corners = []
    for i in range(parts):
        for j in range(parts - i):
            k = parts - 1 - i - j
            corners.append([[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]])
            if k > 0:
                corners.append([[i, j + 1, k], [i + 1, j, k], [i + 1, j + 1, k - 1]])
    L = np.concatenate([TRIANGLE_POINTS @ (np.array(corner) / parts) for corner in corners])
    return FaceRule(L, np.tile(TRIANGLE_WEIGHTS, parts**2) / parts**2)
