"""Bodies of simple shape, for verification, hard cases and comparison with other programs.

A thin layer of solid elements on a boundary: skin or superficial fascia, resolved.

A quadratic triangle of the boundary, corners v, and its image, corners w, bound a prism, which is cut into
three tetrahedra. With v0 < v1 < v2 by node number the diagonals of its sides go from the lower v to the
higher w, so that neighbours cut their common side alike.
"""

from dataclasses import dataclass, replace
from itertools import permutations

import gmsh
import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.lattice import NODE_MM, on_lattice
from mammosim.meshing.quality import quality
from mammosim.meshing.tetrahedra import gmsh_session, quadratic

QUADRATIC_TRIANGLE, QUADRATIC_TETRAHEDRON = 9, 11  # gmsh element types
# gmsh numbers the last two mid-edge nodes of a quadratic tetrahedron the other way round.
_FROM_GMSH = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]

# How far from the sphere or the base a node may be and count as on it: ten times the rounding of the nodes.
ON_SURFACE_MM = 1e-5


def box(
    counts: tuple[int, int, int], size_mm: tuple[float, float, float], *, posterior_axis: int = 2
) -> TetMesh:
    """A box [0, size] of six tetrahedra a brick, counts of bricks along x, y, z, all ADIPOSE.

    `posterior` is its face at 0 of an axis, `skin` are the others.
    """
    grid = np.stack(np.meshgrid(*(np.arange(n + 1) for n in counts), indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    corner = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    tetrahedra = []
    for order in permutations(range(3)):
        path = np.cumsum(np.vstack([np.zeros(3, int), np.eye(3, dtype=int)[list(order)]]), axis=0)
        nodes = np.stack([number[tuple((corner + step).T)] for step in path], axis=1)
        odd = np.linalg.det(np.diff(path, axis=0)) < 0
        tetrahedra.append(nodes[:, [0, 2, 1, 3]] if odd else nodes)
    vertices = grid.reshape(-1, 3) * (np.array(size_mm) / counts)
    points, cells = quadratic(vertices, np.vstack(tetrahedra))
    outer = boundary_faces(cells)
    held = np.all(points[outer][:, :, posterior_axis] == 0.0, axis=1)
    boundaries = {"posterior": outer[held], "skin": outer[~held]}
    return TetMesh(points, cells, np.full(len(cells), int(Label.ADIPOSE)), boundaries)


def ball_part(radius_mm: float, edge_mm: float, *, octant: bool = False) -> TetMesh:
    """The half z > 0 of a ball about the origin, or the octant x, y, z > 0, with curved edges, all ADIPOSE.

    `posterior` lies in z = 0, `skin` on the sphere, both to NODE_MM. The same input gives the same mesh.
    Raises MeshError when the elements are no smaller than the ball.
    """
    if not 0 < edge_mm <= radius_mm:
        raise MeshError(f"edge_mm {edge_mm:g} is outside (0, radius_mm = {radius_mm:g}]")
    with gmsh_session():
        gmsh.option.setNumber("Mesh.MeshSizeMin", edge_mm)
        gmsh.option.setNumber("Mesh.MeshSizeMax", edge_mm)
        turn = np.pi / 2 if octant else 2 * np.pi
        gmsh.model.occ.addSphere(0, 0, 0, radius_mm, angle1=0, angle2=np.pi / 2, angle3=turn)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        cells = gmsh.model.mesh.getElementsByType(QUADRATIC_TETRAHEDRON)[1].reshape(-1, 10)[:, _FROM_GMSH]
        faces = gmsh.model.mesh.getElementsByType(QUADRATIC_TRIANGLE)[1].reshape(-1, 6)
    used = np.unique(cells)
    points = on_lattice(coordinates, NODE_MM).reshape(-1, 3)[np.argsort(tags)]
    points = points[np.searchsorted(np.sort(tags), used)]
    cells, faces = np.searchsorted(used, cells), np.searchsorted(used, faces)
    on_sphere = np.all(np.linalg.norm(points, axis=1)[faces] > radius_mm - ON_SURFACE_MM, axis=1)
    in_base = np.all(np.abs(points[faces][:, :, 2]) < ON_SURFACE_MM, axis=1)
    boundaries = {"skin": faces[on_sphere], "posterior": faces[in_base & ~on_sphere]}
    return TetMesh(points, cells, np.full(len(cells), int(Label.ADIPOSE)), boundaries)


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
