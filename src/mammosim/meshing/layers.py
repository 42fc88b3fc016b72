"""A thin layer of solid elements on a boundary: skin or superficial fascia, resolved.

A quadratic triangle of the boundary, corners v, and its image, corners w, bound a prism, which is cut into
three tetrahedra. With v0 < v1 < v2 by node number the diagonals of its sides go from the lower v to the
higher w, so that neighbours cut their common side alike.
"""

from dataclasses import dataclass, replace

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.quality import quality

# Corners of the tetrahedra of a prism, v 0-2 and w 3-5, for v0, v1, v2 counter-clockwise seen from w.
_TETRAHEDRA = np.array([(0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)])
_MIRRORED = _TETRAHEDRA[:, [0, 2, 1, 3]]


def with_layer(
    mesh: TetMesh, outer: np.ndarray, *, tissue: Label = Label.SKIN, boundary: str = "skin"
) -> TetMesh:
    """The mesh with one layer of quadratic tetrahedra on a boundary, which moves to the layer's outside.

    outer (n_node, 3) mm: where the images of the boundary's nodes lie; rows of other nodes are not used.
    What was the boundary becomes `fascia`; the layer's sides join `posterior` where their rim meets it.
    Raises MeshError when elements of the layer are inverted: outer lies inside, or is too far for its shape.
    """
    prisms = _Prisms.on(mesh, mesh.boundaries[boundary], outer)
    cells = prisms.cells()
    whole = replace(
        mesh,
        points=prisms.points,
        cells=np.vstack([mesh.cells, cells]),
        tissue=np.concatenate([mesh.tissue, np.full(len(cells), int(tissue))]),
    )
    _require_upright(quality(whole)["smallest_J"].to_numpy()[len(mesh.cells) :])
    held = np.union1d(mesh.boundary_nodes("posterior"), prisms.image[mesh.boundary_nodes("posterior")])
    shell = boundary_faces(cells)
    level = (shell >= len(mesh.points)).sum(axis=1)
    sides = shell[(level > 0) & (level < 6) & np.isin(shell[:, :3], held).all(axis=1)]
    boundaries = {
        **mesh.boundaries,
        boundary: prisms.image[prisms.faces],
        "fascia": prisms.faces,
        "posterior": np.vstack([mesh.boundaries["posterior"], sides]),
    }
    return replace(whole, boundaries=boundaries)


@dataclass(frozen=True)
class _Prisms:
    """faces (n_face, 6) below; image (n_node,) of each node, -1 elsewhere; points of the whole mesh.

    edges (n_edge, 2): ascending vertices of the faces' edges and, twice the same, of the uprights; middle
    (n_edge,): the node below at its middle. A new node half way between it and its image follows the images.
    """

    faces: np.ndarray
    image: np.ndarray
    points: np.ndarray
    edges: np.ndarray
    middle: np.ndarray

    @classmethod
    def on(cls, mesh: TetMesh, faces: np.ndarray, outer: np.ndarray) -> "_Prisms":
        nodes = np.unique(faces)
        image = np.full(len(mesh.points), -1)
        image[nodes] = len(mesh.points) + np.arange(len(nodes))
        vertices = np.unique(faces[:, :3])
        edges = np.vstack(
            [np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), vertices[:, None].repeat(2, 1)]
        )
        middle = np.concatenate([faces[:, 3:].ravel(), vertices])
        edges, first = np.unique(edges, axis=0, return_index=True)
        middle = middle[first]
        half_way = (mesh.points[middle] + outer[middle]) / 2
        return cls(faces, image, np.vstack([mesh.points, outer[nodes], half_way]), edges, middle)

    def cells(self) -> np.ndarray:
        """(3 n_face, 10)."""
        order = np.argsort(self.faces[:, :3], axis=1)
        v = np.take_along_axis(self.faces[:, :3], order, axis=1)
        clockwise = np.linalg.det(np.eye(3)[order]) < 0
        cut = np.where(clockwise[:, None, None], _MIRRORED, _TETRAHEDRA)
        corners = np.hstack([v, self.image[v]])
        tetrahedra = np.take_along_axis(corners[:, None, :], cut, axis=2).reshape(-1, 4)
        below = np.take_along_axis(np.hstack([v, v])[:, None, :], cut, axis=2).reshape(-1, 4)
        return np.hstack([tetrahedra, self._middles(tetrahedra, below)])

    def _middles(self, tetrahedra: np.ndarray, below: np.ndarray) -> np.ndarray:
        """(n_cell, 6) mid-edge nodes; below (n_cell, 4): the corners projected onto the faces."""
        pairs = np.sort(below[:, np.array(EDGES)], axis=2)
        n = len(self.image)
        edge = np.searchsorted(self.edges @ [n, 1], pairs @ [n, 1])
        lifted = (tetrahedra != below)[:, np.array(EDGES)].sum(axis=2)
        m = self.middle[edge]
        half_way = len(self.points) - len(self.edges) + edge
        return np.choose(lifted, [m, half_way, self.image[m]])


def _require_upright(smallest_J: np.ndarray) -> None:
    bad = np.flatnonzero(~(smallest_J > 0))
    if len(bad):
        raise MeshError(
            f"{len(bad)} of {len(smallest_J)} elements of the layer are inverted or flat; "
            "its outside must lie outside the boundary, and nearer than the boundary's radius of curvature"
        )
