"""A block of tissue as a small structured mesh."""

from collections.abc import Callable

import numpy as np
import pytest

from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, FACES, TetMesh

# Six tetrahedra of a cube, as corners numbered x + 2 y + 4 z.
CUBE = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])


@pytest.fixture(scope="session")
def block() -> Callable[..., TetMesh]:
    """block(n, size): a cube from 0 to size mm, n elements along an edge, held at its highest y."""
    return make_block


def make_block(n: int = 3, size: float = 30.0) -> TetMesh:
    steps = np.arange(n + 1) * size / n
    z, y, x = np.meshgrid(steps, steps, steps, indexing="ij")
    corners = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    offsets = np.array([(c & 1) + ((c >> 1) & 1) * (n + 1) + (c >> 2) * (n + 1) ** 2 for c in range(8)])
    first = np.ravel_multi_index(np.indices((n, n, n)).reshape(3, -1), (n + 1,) * 3)
    tets = (first[:, None, None] + offsets[CUBE][None]).reshape(-1, 4)
    ends = np.sort(tets[:, np.array(EDGES)], axis=2).reshape(-1, 2)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    points = np.vstack([corners, corners[edges].mean(axis=1)])
    cells = np.hstack([tets, len(corners) + number.reshape(-1, 6)])
    faces = cells[:, np.array(FACES)].reshape(-1, 6)
    _, index, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[index[count == 1]]
    held = np.all(np.isclose(points[outer][..., 1], size), axis=1)
    tissue = np.full(len(cells), Label.ADIPOSE, np.uint8)
    return TetMesh(points, cells, tissue, {"skin": outer[~held], "posterior": outer[held]})
