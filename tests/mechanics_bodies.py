"""Simple bodies for the tests of the mechanics: boxes cut by hand, and parts of a ball cut by gmsh."""

from itertools import permutations

import gmsh
import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, FACES, TetMesh

# gmsh numbers the last two mid-edge nodes of a quadratic tetrahedron the other way round.
_FROM_GMSH = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


def box(counts=(2, 2, 2), size=(1.0, 1.0, 1.0), posterior_axis=2):
    """A box of six tetrahedra a brick; `posterior` is its face at 0 of an axis, `skin` the rest."""
    grid = np.stack(np.meshgrid(*(np.arange(n + 1) for n in counts), indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    corner = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    tets = []
    for order in permutations(range(3)):
        path = np.cumsum(np.vstack([np.zeros(3, int), np.eye(3, dtype=int)[list(order)]]), axis=0)
        nodes = np.stack([number[tuple((corner + step).T)] for step in path], axis=1)
        odd = np.linalg.det(np.diff(path, axis=0)) < 0
        tets.append(nodes[:, [0, 2, 1, 3]] if odd else nodes)
    points = grid.reshape(-1, 3) * (np.array(size) / counts)
    return _quadratic(points, np.vstack(tets), posterior_axis)


def _quadratic(points, tets, posterior_axis):
    edges = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    unique, which = np.unique(edges, axis=0, return_inverse=True)
    cells = np.hstack([tets, len(points) + which.reshape(-1, 6)])
    points = np.vstack([points, points[unique].mean(axis=1)])
    faces = cells[:, FACES].reshape(-1, 6)
    _, first, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[first[count == 1]]
    held = np.all(points[outer][:, :, posterior_axis] == 0.0, axis=1)
    boundaries = {"posterior": outer[held], "skin": outer[~held]}
    return TetMesh(points, cells, np.full(len(cells), int(Label.ADIPOSE)), boundaries)


def sphere_part(radius, edge, *, octant=False):
    """Half of a ball, z > 0, or its octant; `posterior` is in z = 0, `skin` on the sphere."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.MeshSizeMin", edge)
        gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
        angles = (np.pi / 2, np.pi / 2) if octant else (np.pi / 2, 2 * np.pi)
        gmsh.model.occ.addSphere(0, 0, 0, radius, angle1=0, angle2=angles[0], angle3=angles[1])
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        cells = gmsh.model.mesh.getElementsByType(11)[1].reshape(-1, 10)[:, _FROM_GMSH]
        faces = gmsh.model.mesh.getElementsByType(9)[1].reshape(-1, 6)
    finally:
        gmsh.finalize()
    used = np.unique(cells)
    points = coordinates.reshape(-1, 3)[np.argsort(tags)][np.searchsorted(np.sort(tags), used)]
    cells, faces = np.searchsorted(used, cells), np.searchsorted(used, faces)
    radii = np.linalg.norm(points, axis=1)
    skin = np.all(radii[faces] > radius - 1e-6, axis=1)
    base = np.all(np.abs(points[faces][:, :, 2]) < 1e-6, axis=1)
    boundaries = {"skin": faces[skin], "posterior": faces[base & ~skin]}
    return TetMesh(points, cells, np.full(len(cells), int(Label.ADIPOSE)), boundaries)


def nearest(mesh, point):
    """The node nearest to a point (3,)."""
    return int(np.argmin(np.linalg.norm(mesh.points - point, axis=1)))
