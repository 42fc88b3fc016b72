"""A closed surface with triangles of the asked size.

Isotropic remeshing (Botsch and Kobbelt 2004): edges shorter than 4/5 of the asked size are collapsed, longer
than 4/3 split, edges flipped where that makes the worse of two triangles better, vertices moved tangentially
and back onto the given surface. Every step keeps the surface closed and without folds, so that this works
for any shape that marching cubes give.
"""

from collections.abc import Callable

import numpy as np

from mammosim.meshing.edges import resized
from mammosim.meshing.nearest import NearestOnTriangles
from mammosim.meshing.surface import Surface

Size = Callable[[np.ndarray], np.ndarray]
"""Edge length (n,) mm wanted at points (n, 3)."""

SWEEPS = 12


def remeshed(surface: Surface, size: Size) -> Surface:
    """The surface with edges of about size(points), its volume kept to second order in the edge length."""
    nearest = NearestOnTriangles(surface.corners())
    points, triangles = surface.points, surface.triangles
    for _ in range(SWEEPS):
        points, triangles = resized(points, triangles, size(points))
        points = _relaxed(points, triangles)
        points = nearest(points)[0]
    return Surface(_balanced(points, triangles, nearest), triangles)


def _relaxed(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Vertices moved in their tangent plane to the area-weighted mean of the triangles around them."""
    area_normal, centre = _area_normals(points, triangles)
    area = np.linalg.norm(area_normal, axis=1)
    normal = _sum_at_vertices(area_normal, triangles, len(points))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    total = _sum_at_vertices(area[:, None], triangles, len(points))
    step = _sum_at_vertices(area[:, None] * centre, triangles, len(points)) / total - points
    return points + step - np.sum(step * normal, axis=1, keepdims=True) * normal


def _balanced(points: np.ndarray, triangles: np.ndarray, nearest: NearestOnTriangles) -> np.ndarray:
    """Vertices moved along their normal so that the flat triangles lie on average on the given surface.

    Over a triangle with its corners on the surface, the mean height d of the surface above it is 3/4 of the
    height above its centre (exact for a quadratic surface); a vertex is raised by the mean d around it.
    """
    area_normal, centre = _area_normals(points, triangles)
    area = np.linalg.norm(area_normal, axis=1)
    d = 3 / 4 * np.sum((nearest(centre)[0] - centre) * area_normal, axis=1) / area
    normal = _sum_at_vertices(area_normal, triangles, len(points))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    total = _sum_at_vertices(area[:, None], triangles, len(points))
    return points + _sum_at_vertices((area * d)[:, None], triangles, len(points)) / total * normal


def _area_normals(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outward normals (m, 3), as long as the triangle's area, and centres (m, 3)."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return np.cross(b - a, c - a) / 2, (a + b + c) / 3


def _sum_at_vertices(values: np.ndarray, triangles: np.ndarray, n: int) -> np.ndarray:
    """Sum (n, k) over the triangles around each vertex of values (m, k)."""
    columns = [
        np.bincount(triangles.ravel(), weights=np.repeat(column, 3), minlength=n) for column in values.T
    ]
    return np.stack(columns, axis=1)
