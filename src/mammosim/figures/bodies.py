"""Meshes as solids to render: the skin with a smooth rim, what a plane cuts open, points and plates."""

import numpy as np
from matplotlib.colors import to_rgb
from scipy.sparse import coo_array, diags_array

from mammosim.core.labels import Label
from mammosim.core.mesh import FACES, SUBTETRAHEDRA, SUBTRIANGLES, TetMesh
from mammosim.figures.render import Solid
from mammosim.figures.style import TISSUE_COLOURS

SKIN_COLOUR = "#e3b79c"
# The rim of the skin follows edges of elements to and fro, in teeth of their size. So many means over
# neighbours smooth it over about three elements; the skin is shown to where its share is this part of the
# largest, about one element from the rim, where no tooth is left.
RIM_MEANS, RIM_SHARE = 30, 0.75


def boundary_triangles(faces: np.ndarray) -> np.ndarray:
    """Four linear triangles (4 n, 3) for each quadratic one, faces (n, 6)."""
    return faces[:, SUBTRIANGLES].reshape(-1, 3)


def skin_solid(mesh: TetMesh, *, colour: str = SKIN_COLOUR) -> Solid:
    """The skin as a smooth surface, with a smooth rim."""
    return coloured_skin(mesh, np.tile(to_rgb(colour), (len(mesh.boundaries["skin"]), 1)))


def coloured_skin(mesh: TetMesh, rgb: np.ndarray) -> Solid:
    """The same with a colour (n_face, 3) for each of its faces."""
    others = [faces for name, faces in mesh.boundaries.items() if name != "skin"]
    share = skin_share(mesh, boundary_triangles(np.vstack([mesh.boundaries["skin"], *others])))
    skin = boundary_triangles(mesh.boundaries["skin"])
    return Solid(mesh.points, skin, np.repeat(rgb, 4, axis=0), inside=share - RIM_SHARE * share.max())


def skin_share(mesh: TetMesh, triangles: np.ndarray) -> np.ndarray:
    """How far a node (n,) lies in the skin, 0 to 1: smooth along the surface, a half at the rim.

    triangles (m, 3): of the whole boundary, those of the skin first.
    """
    n, n_skin = len(mesh.points), 4 * len(mesh.boundaries["skin"])
    around = np.bincount(triangles.ravel(), minlength=n)
    share = np.bincount(triangles[:n_skin].ravel(), minlength=n) / np.maximum(around, 1)
    i, j = triangles[:, [0, 1, 2]].ravel(), triangles[:, [1, 2, 0]].ravel()
    links = coo_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), shape=(n, n)).tocsr()
    mean = diags_array(1 / np.maximum(links.sum(axis=1), 1)) @ links
    for _ in range(RIM_MEANS):
        share = (share + mean @ share) / 2
    return share


def cut_solids(mesh: TetMesh, at_x_mm: float, rgb: np.ndarray, *, edges: bool = False) -> tuple[Solid, Solid]:
    """What is left of a body at a smaller x than a sagittal plane: its outside, and the plane's section.

    rgb (n_cell, 3); edges: draw those of the elements.
    """
    faces = mesh.cells[:, np.array(FACES)].reshape(-1, 6)
    _, index, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    outer = index[count == 1]
    cells = np.repeat(outer // len(FACES), len(SUBTRIANGLES))
    inside = at_x_mm - mesh.points[:, 0]
    points, triangles, tets = section(mesh, at_x_mm)
    return (
        Solid(
            mesh.points,
            boundary_triangles(faces[outer]),
            rgb[cells],
            parts=cells if edges else None,
            inside=inside,
        ),
        Solid(points, triangles, rgb[tets], lit=False, parts=tets if edges else None),
    )


def section(mesh: TetMesh, at_x_mm: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (3 m, 3), triangles (m, 3) facing larger x, and cells (m,) where x = at_x_mm cuts the elements.

    An element is cut as its eight linear ones, whose outside is that of boundary_triangles.
    """
    linear = mesh.cells[:, np.array(SUBTETRAHEDRA)].reshape(-1, 4)
    h = mesh.points[linear, 0] - at_x_mm
    corners, owners = [], []
    for above in (1, 2, 3):
        cut = np.flatnonzero((h > 0).sum(axis=1) == above)
        order = np.argsort(h[cut] <= 0, axis=1, kind="stable")
        nodes = np.take_along_axis(linear[cut], order, axis=1)
        # One corner apart from three leaves a triangle, two from two a quadrilateral.
        pairs = {
            1: ((0, 1), (0, 2), (0, 3)),
            2: ((0, 2), (0, 3), (1, 3), (1, 2)),
            3: ((0, 3), (1, 3), (2, 3)),
        }[above]
        ends = np.stack([_crossing(mesh.points, nodes[:, a], nodes[:, b], at_x_mm) for a, b in pairs], axis=1)
        for k in range(len(pairs) - 2):
            corners.append(ends[:, [0, k + 1, k + 2]])
            owners.append(cut // len(SUBTETRAHEDRA))
    p = np.vstack(corners)
    turned = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 0] < 0
    p[turned] = p[turned][:, ::-1]
    return p.reshape(-1, 3), np.arange(3 * len(p)).reshape(-1, 3), np.concatenate(owners)


def _crossing(points: np.ndarray, a: np.ndarray, b: np.ndarray, at_x_mm: float) -> np.ndarray:
    """Where the lines from nodes a (n,) to b (n,) cross the plane (n, 3)."""
    p, q = points[a], points[b]
    t = (at_x_mm - p[:, :1]) / (q[:, :1] - p[:, :1])
    ends: np.ndarray = p + t * (q - p)
    return ends


def tissue_rgb(tissue: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of tissues (n,)."""
    return np.array([to_rgb(TISSUE_COLOURS[label]) for label in Label])[tissue]


def balls_solid(points: np.ndarray, colour: str, *, radius_mm: float = 3.5) -> Solid:
    """A small ball at each of points (n, 3) mm."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 13), np.linspace(0, 2 * np.pi, 25)[:-1], indexing="ij")
    ball = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(12), np.arange(24), indexing="ij"))
    a, b, c, d = i * 24 + j, (i + 1) * 24 + j, (i + 1) * 24 + (j + 1) % 24, i * 24 + (j + 1) % 24
    triangles = np.vstack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    surfaces = points[:, None] + radius_mm * ball.reshape(-1, 3)
    numbers = triangles + np.arange(len(points))[:, None, None] * len(surfaces[0])
    return Solid.of(surfaces.reshape(-1, 3), numbers.reshape(-1, 3), colour)


def box_solid(centre: np.ndarray, axes: np.ndarray, half_sizes: np.ndarray, *, opacity: float = 0.3) -> Solid:
    """A plate: box with axes (3, 3) in columns."""
    signs = np.array([[(k & 1) * 2 - 1, (k >> 1 & 1) * 2 - 1, (k >> 2) * 2 - 1] for k in range(8)])
    quads = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    points = centre + (signs * half_sizes) @ axes.T
    sides = np.repeat(np.arange(len(quads)), 2)
    return Solid.of(points, triangles, "#8fb4d6", smooth=False, opacity=opacity, parts=sides)
