"""The faces on the outside of a mesh, and what lies beyond them."""

import numpy as np
from scipy import ndimage
from skfem import MeshTet
from skfem.refdom import RefTet

from mammosim.core.labels import DEFORMABLE
from mammosim.core.mesh import FACES, TetMesh
from mammosim.core.volume import LabelMap
from mammosim.meshing.lattice import POINT_MM, on_lattice
from mammosim.meshing.surface import OPEN

_FACET = [RefTet.facets.index(sorted(face[:3])) for face in FACES]  # scikit-fem's number of each of FACES


def boundary_faces(cells: np.ndarray) -> np.ndarray:
    """Quadratic triangles (n_face, 6), normals outward, that belong to one cell (n_cell, 10) only."""
    facet = topology(cells[:, :4]).t2f[_FACET].T
    return cells[:, FACES][np.bincount(facet.ravel())[facet] == 1]


def topology(tetrahedra: np.ndarray) -> MeshTet:
    """Facets and edges of tetrahedra (n_cell, 4), by scikit-fem; its points are all zero."""
    return MeshTet(np.zeros((3, tetrahedra.max() + 1)), np.ascontiguousarray(tetrahedra.T))


def named_boundaries(mesh: TetMesh, labels: LabelMap) -> dict[str, np.ndarray]:
    """`skin`: faces nearer to air than to what holds the tissue; `posterior`: all others.

    The thorax holds it, and whatever lies beyond the image; distances are means over a face's six nodes,
    compared to POINT_MM.
    """
    faces = boundary_faces(mesh.cells)
    opened = np.pad(np.isin(labels.values, OPEN), 1)
    held = np.pad(~np.isin(labels.values, (*OPEN, *DEFORMABLE)), 1, constant_values=True)
    nodes = 1 + labels.grid.indices(mesh.points[faces].reshape(-1, 3))
    to_air, to_held = (
        on_lattice(_distance(outside, labels, nodes).reshape(-1, 6).mean(axis=1), POINT_MM)
        for outside in (opened, held)
    )
    return {"skin": faces[to_air < to_held], "posterior": faces[to_air >= to_held]}


def _distance(mask: np.ndarray, labels: LabelMap, indices: np.ndarray) -> np.ndarray:
    """Distance (n,) mm from array indices (n, 3) to the nearest centre of a voxel in the mask."""
    if not mask.any():
        return np.full(len(indices), np.inf)
    field = ndimage.distance_transform_edt(~mask, sampling=labels.grid.spacing[::-1])
    return ndimage.map_coordinates(field.astype(np.float32), indices.T, order=1, mode="nearest")
