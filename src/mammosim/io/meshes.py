"""Meshes as VTK files (.vtu): tetrahedra and boundary triangles, quadratic, in mm, LPS.

Cell data `tissue` holds the label of a tetrahedron (0 on triangles), `shares` those of every label in its
volume (nan on triangles), where cells are of several tissues, `boundary` the number of a triangle's
boundary in BOUNDARY_NUMBERS (0 on tetrahedra). Field data `tissue_1_adipose` and so on name the labels.
"""

import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import meshio
import numpy as np

from mammosim.core.errors import DamagedMesh, MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.io.atomic import replacing
from mammosim.io.missing import AGAIN, require_there

BOUNDARY_NUMBERS = {"skin": 1, "posterior": 2}
CELL, FACE = "tetra10", "triangle6"


def write_mesh(
    mesh: TetMesh,
    path: str | Path,
    *,
    point_data: Mapping[str, np.ndarray] | None = None,
    cell_data: Mapping[str, np.ndarray] | None = None,
    skin_data: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Write a mesh and fields on it to path, a `.vtu` file that ParaView reads.

    point_data: name -> (n_node, ...); cell_data: name -> (n_cell, ...); skin_data: name -> (n_face, ...) on
    the faces of the skin, names that are none of cell_data; units in the names.
    Tensors are stored as rows of components. Cell data are nan, or 0 where integers, on boundary triangles,
    and skin data on all but those of the skin.
    Raises MeshError when a boundary has no number in BOUNDARY_NUMBERS.
    """
    if unknown := sorted(set(mesh.boundaries) - set(BOUNDARY_NUMBERS)):
        raise MeshError(f"unknown boundary {unknown[0]!r}; choose one of: {', '.join(BOUNDARY_NUMBERS)}")
    faces = np.concatenate([np.empty((0, 6), dtype=np.int64), *mesh.boundaries.values()])
    numbers = [np.full(len(f), BOUNDARY_NUMBERS[name]) for name, f in mesh.boundaries.items()]
    on_faces = np.concatenate([np.empty(0), *numbers]).astype(np.uint8)
    fields = {name: [v, _nothing(v, len(faces))] for name, v in _rows(cell_data).items()}
    on_skin = on_faces == BOUNDARY_NUMBERS["skin"]
    for name, values in _rows(skin_data).items():
        fields[name] = [_nothing(values, len(mesh.cells)), _nothing(values, len(faces))]
        fields[name][1][on_skin] = values
    fields["tissue"] = [mesh.tissue.astype(np.uint8), np.zeros(len(faces), dtype=np.uint8)]
    if mesh.shares is not None:
        fields["shares"] = [mesh.shares, _nothing(mesh.shares, len(faces))]
    fields["boundary"] = [np.zeros(len(mesh.cells), dtype=np.uint8), on_faces]
    cells = [(CELL, mesh.cells), (FACE, faces)]
    stored = meshio.Mesh(mesh.points, cells, point_data=_rows(point_data), cell_data=fields)
    with replacing(path) as temporary:
        meshio.vtu.write(temporary, stored, binary=True, compression="zlib")
        _tell_tissues(temporary)


def _tell_tissues(path: Path) -> None:
    """Add to a `.vtu` what its numbers mean: field data tissue_1_adipose and so on, and components of shares.

    Arrays of one number each, since meshio reads no text.
    """
    head, grid, rest = path.read_bytes().partition(b"<UnstructuredGrid>")
    told = "".join(
        f'<DataArray type="UInt8" Name="tissue_{label:d}_{label.tissue}" NumberOfTuples="1" format="ascii">'
        f"{label:d}</DataArray>"
        for label in Label
    )
    names = " ".join(f'ComponentName{label:d}="{label.tissue}"' for label in Label)
    rest = rest.replace(b'Name="shares"', f'Name="shares" {names}'.encode(), 1)
    path.write_bytes(head + grid + f"<FieldData>{told}</FieldData>".encode() + rest)


def _rows(fields: Mapping[str, np.ndarray] | None) -> dict[str, np.ndarray]:
    """Fields (n,) or (n, k): vtk has no further axes."""
    return {name: v if v.ndim == 1 else v.reshape(len(v), -1) for name, v in (fields or {}).items()}


def _nothing(values: np.ndarray, n: int) -> np.ndarray:
    shape = (n, *values.shape[1:])
    if np.issubdtype(values.dtype, np.floating):
        return np.full(shape, np.nan, dtype=values.dtype)
    return np.zeros(shape, dtype=values.dtype)


def read_mesh(path: str | Path) -> TetMesh:
    """Read a mesh.

    path: a `.vtu` file. Returns the mesh that `write_mesh` wrote, points in mm, its boundaries in the order
    of BOUNDARY_NUMBERS.

    Raises MeshError when the file holds no quadratic tetrahedra or no tissue, MissingResult when it says that
    the mesh is missing.
    """
    stored = _read(path)
    if absent := [name for name in ("tissue", "boundary") if name not in stored.cell_data]:
        raise MeshError(f"{path} has no cell data {absent[0]!r}; write it with write_mesh")
    faces = stored.cells_dict.get(FACE, np.empty((0, 6), dtype=np.int64))
    on_faces = stored.cell_data_dict["boundary"].get(FACE, np.empty(0))
    boundaries = {name: faces[on_faces == n] for name, n in BOUNDARY_NUMBERS.items() if n in on_faces}
    shares = stored.cell_data_dict["shares"][CELL] if "shares" in stored.cell_data else None
    tissue = _on_cells(stored, "tissue", path)
    return TetMesh(stored.points, stored.cells_dict[CELL], tissue, boundaries, shares)


def read_point_data(path: str | Path, name: str) -> np.ndarray:
    """A field (n_node,) or (n_node, k) on the nodes. Raises MeshError when the file has none of that name."""
    stored = _read(path)
    if name not in stored.point_data:
        raise MeshError(
            f"{path} has no point data {name!r}; it has: {', '.join(stored.point_data) or 'none'}"
        )
    return stored.point_data[name]


def read_cell_data(path: str | Path, name: str) -> np.ndarray:
    """A field (n_cell,) or (n_cell, k) on the cells. Raises MeshError when the file has none of that name."""
    return _on_cells(_read(path), name, path)


def read_skin_data(path: str | Path, name: str) -> np.ndarray:
    """A field (n_face,) or (n_face, k) on the skin's faces. Raises MeshError when the file has none such."""
    stored = _read(path)
    on_faces = stored.cell_data_dict.get(name, {}).get(FACE)
    if on_faces is None:
        raise MeshError(f"{path} has no data {name!r} on faces; it has: {', '.join(stored.cell_data)}")
    found: np.ndarray = on_faces[stored.cell_data_dict["boundary"][FACE] == BOUNDARY_NUMBERS["skin"]]
    return found


def _read(path: str | Path) -> meshio.Mesh:
    if not Path(path).is_file():
        raise MeshError(f"no mesh {path}; run the stage that makes it, or correct the path")
    require_there(path)
    try:
        stored = meshio.vtu.read(path)
    except Exception as error:  # of XML, of base64, of zlib with its checksum, or of numbers that do not fit
        reason = " ".join(f"{type(error).__name__} {error}".split())
        raise DamagedMesh(f"{path} is cut short or damaged ({reason}); {AGAIN}") from None
    if CELL not in stored.cells_dict:
        raise MeshError(
            f"{path} holds no quadratic tetrahedra ({CELL}), only: {', '.join(stored.cells_dict)}"
        )
    return stored


def _on_cells(stored: meshio.Mesh, name: str, path: str | Path) -> np.ndarray:
    if name not in stored.cell_data:
        raise MeshError(f"{path} has no cell data {name!r}; it has: {', '.join(stored.cell_data)}")
    return stored.cell_data_dict[name][CELL]


_BOUNDARY = "boundary_"


def write_mesh_arrays(mesh: TetMesh, path: str | Path) -> None:
    """Write points (n_node, 3), cells (n_cell, 10) in VTK order, tissue (n_cell,), boundary_NAME (n, 6).

    Raises MeshError for cells of several tissues, of which other programs know nothing.
    """
    if mesh.shares is not None:
        raise MeshError("cells of several tissues have no place in plain arrays; give a mesh without shares")
    arrays = {"points": mesh.points, "cells": mesh.cells, "tissue": mesh.tissue}
    arrays |= {_BOUNDARY + name: faces for name, faces in mesh.boundaries.items()}
    with replacing(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def read_mesh_arrays(path: str | Path) -> TetMesh:
    """The mesh that `write_mesh_arrays` wrote.

    Raises MeshError when one of its arrays is missing, DamagedMesh when the file is cut short or damaged.
    """
    with _arrays(path) as arrays:
        if absent := {"points", "cells", "tissue"} - set(arrays):
            raise MeshError(
                f"{path} lacks {', '.join(sorted(absent))}; write the mesh with write_mesh_arrays"
            )
        boundaries = {
            name.removeprefix(_BOUNDARY): arrays[name] for name in arrays if name.startswith(_BOUNDARY)
        }
        return TetMesh(arrays["points"], arrays["cells"], arrays["tissue"], boundaries)


@contextmanager
def _arrays(path: str | Path) -> Iterator[Any]:
    require_there(path)
    try:
        with np.load(path) as arrays:
            yield arrays
    except (BadZipFile, zlib.error, EOFError, ValueError) as error:
        raise DamagedMesh(f"{path} is cut short or damaged ({error}); {AGAIN}") from None
