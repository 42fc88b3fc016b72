"""Whether a deformed body passes through itself, which no energy of its tissue forbids: J > 0 is local.

A point y of the skin lies in the linear tetrahedron v of a cell when its barycentric coordinates there,
(v_1 - v_0, v_2 - v_0, v_3 - v_0)^-1 (y - v_0) and what they lack of 1, are positive; each cell is cut into
eight. Cells that share a node with the point's face touch it anyway, and are left out.
"""

import numpy as np
from scipy.spatial import cKDTree

from mammosim.core.mesh import SUBTETRAHEDRA, TetMesh
from mammosim.mechanics.reference import TRIANGLE, shape_functions

# One point a face, on no line of symmetry, where it would lie between two tetrahedra.
_POINT = np.array([[0.53, 0.29, 0.18]])
# Least barycentric coordinate inside: a curved face that touches another lies as deep in its tetrahedra.
_DEEP = 0.03


def faces_inside(mesh: TetMesh, x: np.ndarray) -> np.ndarray:
    """Numbers (n,) of the skin's faces that lie inside other cells of the shape x (n_node, 3)."""
    faces = mesh.boundaries["skin"]
    y = np.einsum("a,eai->ei", shape_functions(_POINT, TRIANGLE)[0], x[faces])
    v = x[mesh.cells[:, np.array(SUBTETRAHEDRA)].reshape(-1, 4)]
    middles = v.mean(axis=1)
    near = cKDTree(y).query_ball_point(middles, np.linalg.norm(v - middles[:, None], axis=2).max(axis=1))
    part = np.repeat(np.arange(len(v)), [len(found) for found in near])
    face = np.array([number for found in near for number in found], dtype=int)
    cell = mesh.cells[part // len(SUBTETRAHEDRA)]
    others = ~np.any(cell[:, :, None] == faces[face][:, None, :], axis=(1, 2))
    part, face = part[others], face[others]
    edges = (v[part, 1:] - v[part, :1]).transpose(0, 2, 1)
    L = np.linalg.solve(edges, (y[face] - v[part, 0])[..., None])[..., 0]
    deep = (L.min(axis=1, initial=1.0) > _DEEP) & (L.sum(axis=1) < 1 - _DEEP)
    return np.unique(face[deep])
