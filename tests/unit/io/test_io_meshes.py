"""Meshes and the fields on them come back as they were written."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, FACES, TetMesh
from mammosim.io.meshes import (
    read_cell_data,
    read_mesh,
    read_mesh_arrays,
    read_point_data,
    write_mesh,
    write_mesh_arrays,
)
from mammosim.meshing.shapes import box

CORNERS = np.array([[0.1, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 1 / 3]])


@pytest.fixture
def mesh() -> TetMesh:
    points = np.vstack([CORNERS, CORNERS[np.array(EDGES)].mean(axis=1)])
    cells = np.arange(20).reshape(2, 10)
    boundaries = {"skin": cells[0][np.array(FACES)[:3]], "posterior": cells[1][np.array(FACES)[3:]]}
    tissue = np.array([Label.GLANDULAR, Label.MUSCLE], dtype=np.uint8)
    return TetMesh(np.vstack([points, points + 50]), cells, tissue, boundaries)


def test_a_mesh_reads_back_bit_for_bit(mesh: TetMesh, tmp_path: Path) -> None:
    write_mesh(mesh, tmp_path / "m.vtu")
    read = read_mesh(tmp_path / "m.vtu")
    for name in ("points", "cells", "tissue"):
        np.testing.assert_array_equal(getattr(read, name), getattr(mesh, name))
    assert list(read.boundaries) == ["skin", "posterior"]
    for name, faces in mesh.boundaries.items():
        np.testing.assert_array_equal(read.boundaries[name], faces)


def test_a_mesh_without_boundaries_reads_back(mesh: TetMesh, tmp_path: Path) -> None:
    write_mesh(replace(mesh, boundaries={}), tmp_path / "m.vtu")
    assert read_mesh(tmp_path / "m.vtu").boundaries == {}


def test_shares_of_tissues_read_back_and_a_mesh_without_has_none(mesh: TetMesh, tmp_path: Path) -> None:
    shares = np.zeros((2, len(Label)))
    shares[:, Label.GLANDULAR], shares[:, Label.MUSCLE] = [2 / 3, 0.1], [1 / 3, 0.9]
    write_mesh(replace(mesh, shares=shares), tmp_path / "m.vtu")
    np.testing.assert_array_equal(read_mesh(tmp_path / "m.vtu").shares, shares)
    write_mesh(mesh, tmp_path / "m.vtu")
    assert read_mesh(tmp_path / "m.vtu").shares is None


def test_fields_read_back_on_nodes_and_cells(mesh: TetMesh, tmp_path: Path) -> None:
    J, strain = np.array([0.9, 1.1]), np.arange(18.0).reshape(2, 3, 3)
    write_mesh(
        mesh, tmp_path / "m.vtu", point_data={"u_mm": mesh.points}, cell_data={"J": J, "strain": strain}
    )
    np.testing.assert_array_equal(read_point_data(tmp_path / "m.vtu", "u_mm"), mesh.points)
    np.testing.assert_array_equal(read_cell_data(tmp_path / "m.vtu", "J"), J)
    np.testing.assert_array_equal(read_cell_data(tmp_path / "m.vtu", "strain"), strain.reshape(2, 9))


def test_the_file_holds_cells_and_boundary_triangles_with_their_numbers(
    mesh: TetMesh, tmp_path: Path
) -> None:
    write_mesh(mesh, tmp_path / "m.vtu")
    stored = meshio.read(tmp_path / "m.vtu")
    assert [(block.type, len(block.data)) for block in stored.cells] == [("tetra10", 2), ("triangle6", 4)]
    assert [list(values) for values in stored.cell_data["boundary"]] == [[0, 0], [1, 1, 1, 2]]
    assert [list(values) for values in stored.cell_data["tissue"]] == [[2, 4], [0, 0, 0, 0]]


def test_the_same_mesh_gives_the_same_bytes(mesh: TetMesh, tmp_path: Path) -> None:
    write_mesh(mesh, tmp_path / "a.vtu")
    write_mesh(mesh, tmp_path / "b.vtu")
    assert (tmp_path / "a.vtu").read_bytes() == (tmp_path / "b.vtu").read_bytes()


def test_an_unknown_boundary_or_field_is_named_with_the_choices(mesh: TetMesh, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="unknown boundary 'front'; choose one of: skin, posterior"):
        write_mesh(replace(mesh, boundaries={"front": mesh.boundaries["skin"]}), tmp_path / "m.vtu")
    assert not list(tmp_path.iterdir())
    write_mesh(mesh, tmp_path / "m.vtu", point_data={"x_mm": mesh.points})
    with pytest.raises(MeshError, match="no point data 'u_mm'; it has: x_mm"):
        read_point_data(tmp_path / "m.vtu", "u_mm")
    with pytest.raises(MeshError, match="no cell data 'J'; it has: tissue, boundary"):
        read_cell_data(tmp_path / "m.vtu", "J")


def test_a_file_without_quadratic_tetrahedra_is_rejected(tmp_path: Path) -> None:
    meshio.Mesh(CORNERS, [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "linear.vtu")
    with pytest.raises(MeshError, match="no quadratic tetrahedra"):
        read_mesh(tmp_path / "linear.vtu")


def test_the_file_says_what_its_labels_and_shares_mean(mesh: TetMesh, tmp_path: Path) -> None:
    shares = np.eye(len(Label))[mesh.tissue]
    write_mesh(replace(mesh, shares=shares), tmp_path / "m.vtu")
    told = meshio.read(tmp_path / "m.vtu").field_data
    assert {name: values.tolist() for name, values in told.items()} == {
        f"tissue_{label:d}_{label.tissue}": [label] for label in Label
    }
    array = next(
        a for a in ElementTree.parse(tmp_path / "m.vtu").iter("DataArray") if a.get("Name") == "shares"
    )
    assert [array.get(f"ComponentName{label:d}") for label in Label] == [label.tissue for label in Label]


def _damaged(path: Path) -> Iterator[bytes]:
    whole = path.read_bytes()
    yield from (whole[:end] for end in np.linspace(0, len(whole) - 12, 12, dtype=int))  # 12: of </VTKFile>
    for at in np.linspace(0.15, 0.8, 9):  # of the arrays
        wrong = bytearray(whole)
        wrong[int(at * len(whole))] ^= 0x01
        yield bytes(wrong)


@pytest.mark.parametrize(
    ("name", "write", "read"),
    [("a.vtu", write_mesh, read_mesh), ("a.npz", write_mesh_arrays, read_mesh_arrays)],
)
def test_a_mesh_that_is_cut_short_or_damaged_is_rejected(tmp_path: Path, name, write, read) -> None:
    write(box((4, 4, 4), np.array([10.0, 10, 10])), tmp_path / name)
    for data in _damaged(tmp_path / name):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(
            MeshError, match=rf"{name} .*(is cut short or damaged|has no|holds no|lacks)"
        ) as error:
            read(tmp_path / name)
        assert "\n" not in str(error.value)


def test_an_absent_mesh_is_named(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"no mesh .*absent\.vtu; run the stage"):
        read_mesh(tmp_path / "absent.vtu")


@pytest.mark.parametrize("name", [b"tissue", b"boundary"])
def test_a_mesh_without_a_field_of_its_own_is_rejected(mesh: TetMesh, tmp_path: Path, name: bytes) -> None:
    write_mesh(mesh, tmp_path / "a.vtu")
    data = (tmp_path / "a.vtu").read_bytes().replace(b'Name="' + name, b'Name="' + name[::-1])
    (tmp_path / "a.vtu").write_bytes(data)
    with pytest.raises(MeshError, match=rf"a\.vtu has no cell data '{name.decode()}'; write it with"):
        read_mesh(tmp_path / "a.vtu")
