"""Meshes as plain numpy arrays (.npz), for programs that know neither VTK nor this package."""

from pathlib import Path

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.mesh import TetMesh
from mammosim.io.atomic import replacing

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
    """The mesh that `write_mesh_arrays` wrote. Raises MeshError when one of its arrays is missing."""
    with np.load(path) as arrays:
        if absent := {"points", "cells", "tissue"} - set(arrays):
            raise MeshError(
                f"{path} lacks {', '.join(sorted(absent))}; write the mesh with write_mesh_arrays"
            )
        boundaries = {
            name.removeprefix(_BOUNDARY): arrays[name] for name in arrays if name.startswith(_BOUNDARY)
        }
        return TetMesh(arrays["points"], arrays["cells"], arrays["tissue"], boundaries)
