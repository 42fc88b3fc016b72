"""A mesh as plain arrays comes back as it was, or the file is rejected."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.io.meshes import read_mesh_arrays, write_mesh_arrays
from mammosim.meshing.shapes import box


def test_a_mesh_comes_back_as_it_was(tmp_path):
    mesh = box((1, 1, 2), (10, 10, 20))
    write_mesh_arrays(mesh, tmp_path / "mesh.npz")
    back = read_mesh_arrays(tmp_path / "mesh.npz")
    assert set(back.boundaries) == set(mesh.boundaries)
    pairs = [(mesh.boundaries[name], back.boundaries[name]) for name in mesh.boundaries]
    for was, now in [
        (mesh.points, back.points),
        (mesh.cells, back.cells),
        (mesh.tissue, back.tissue),
        *pairs,
    ]:
        np.testing.assert_array_equal(was, now)


def test_a_file_without_cells_is_rejected(tmp_path):
    np.savez(tmp_path / "mesh.npz", points=np.zeros((4, 3)), tissue=np.zeros(1))
    with pytest.raises(MeshError, match="lacks cells"):
        read_mesh_arrays(tmp_path / "mesh.npz")


def test_cells_of_several_tissues_are_rejected(tmp_path):
    mesh = box((1, 1, 2), (10, 10, 20))
    with pytest.raises(MeshError, match="cells of several tissues have no place in plain arrays"):
        write_mesh_arrays(replace(mesh, shares=mesh.composition), tmp_path / "mesh.npz")
