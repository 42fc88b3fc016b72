"""Quality is one for a regular element, and a mesh that cannot be computed with is rejected."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.meshing.quality import quality, require_sound

REGULAR = np.array([[1.0, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1]])


def _mesh(*corners: np.ndarray) -> TetMesh:
    points = np.vstack([np.vstack([c, c[np.array(EDGES)].mean(axis=1)]) for c in corners])
    cells = np.arange(10 * len(corners)).reshape(-1, 10)
    return TetMesh(points, cells, np.ones(len(cells), dtype=np.uint8))


def test_a_regular_tetrahedron_has_quality_one_at_any_size() -> None:
    table = quality(_mesh(REGULAR, 7 * REGULAR))
    np.testing.assert_allclose(table[["mean_ratio", "aspect_ratio", "smallest_J"]], 1, rtol=1e-12)
    # A regular tetrahedron of edge sqrt(8) has the volume sqrt(8)^3 / (6 sqrt(2)) = 8 / 3.
    np.testing.assert_allclose(table["volume_mm3"], [8 / 3, 8 / 3 * 343], rtol=1e-12)


def test_a_squeezed_element_is_worse_by_both_measures() -> None:
    table = quality(_mesh(REGULAR, REGULAR * [1, 1, 0.1]))
    assert table["mean_ratio"][1] < 0.5
    assert table["aspect_ratio"][1] > 4


def test_a_sound_mesh_passes() -> None:
    require_sound(_mesh(REGULAR))


def test_a_bent_edge_that_turns_a_corner_over_counts_as_inverted() -> None:
    mesh = _mesh(REGULAR)
    points = mesh.points.copy()
    points[4] = (
        0.95 * points[0] + 0.05 * points[2]
    )  # the middle of edge 0-1 next to corner 0, towards corner 2
    with pytest.raises(MeshError, match="1 cells are inverted: 0"):
        require_sound(mesh.moved_to(points))


def _empty_boundary() -> TetMesh:
    return replace(_mesh(REGULAR), boundaries={"skin": np.empty((0, 6), dtype=int)})


def _unattached() -> TetMesh:
    mesh = _mesh(REGULAR)
    return replace(mesh, points=np.vstack([mesh.points, np.zeros((2, 3))]))


def _nan() -> TetMesh:
    mesh = _mesh(REGULAR)
    return mesh.moved_to(np.where(np.arange(10)[:, None] == 3, np.nan, mesh.points))


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (_mesh(REGULAR, REGULAR[[1, 0, 2, 3]]), "1 cells are inverted: 1"),
        (_mesh(REGULAR * [1, 1, 0.001]), "1 cells are flat .*: 0"),
        (_mesh(REGULAR, REGULAR + 10), "2 pieces of 10, 10 nodes, of which 2 are not held"),
        (_unattached(), "2 nodes belong to no cell: 10, 11"),
        (_nan(), "1 nodes have coordinates that are not finite: 3"),
        (_empty_boundary(), "boundary 'skin' has no faces"),
    ],
)
def test_a_mesh_that_cannot_be_computed_with_is_rejected(mesh: TetMesh, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        require_sound(mesh)
