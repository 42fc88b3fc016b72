"""The truth's own mesh does not depend on the last digits of the fields that it is made of."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mammosim.digital.anatomy import Anatomy
from mammosim.digital.loading import truth_mesh

SIZES = {"breast_mm": 16.0, "chest_mm": 20.0}
FIELDS = ("soft_tissue_field", "outer_field", "rib_distance", "region_field")


class Shaken:
    """An anatomy whose fields differ by up to 1e-9 mm at random, far more than their last bits."""

    def __init__(self, anatomy: Anatomy) -> None:
        self._anatomy, self._rng = anatomy, np.random.default_rng(0)

    def __getattr__(self, name: str) -> Any:
        exact = getattr(self._anatomy, name)
        return self._noisy(exact) if name in FIELDS else exact

    def _noisy(self, field: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
        return lambda points: field(points) + self._rng.uniform(-1e-9, 1e-9, len(points))


def test_the_same_truth_comes_of_fields_that_differ_in_their_last_digits(
    anatomies: dict[str, Anatomy],
) -> None:
    wanted = truth_mesh(anatomies["small"], **SIZES)
    mesh = truth_mesh(Shaken(anatomies["small"]), **SIZES)
    np.testing.assert_array_equal(mesh.points, wanted.points)
    np.testing.assert_array_equal(mesh.cells, wanted.cells)
    np.testing.assert_array_equal(mesh.tissue, wanted.tissue)
    for name in ("skin", "posterior"):
        np.testing.assert_array_equal(mesh.boundaries[name], wanted.boundaries[name])
