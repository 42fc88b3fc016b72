"""Bodies of simple shape, for verification, hard cases and comparison with other programs."""

from itertools import permutations

import gmsh
import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.lattice import NODE_MM, on_lattice
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
