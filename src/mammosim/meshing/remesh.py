"""A closed surface with triangles of the asked size.

Isotropic remeshing (Botsch and Kobbelt 2004): edges shorter than 4/5 of the asked size are collapsed, longer
than 4/3 split, edges flipped where that makes the worse of two triangles better, vertices moved tangentially
and back onto the given surface, at last to where they fit it best. The surface stays closed at every step.
Creases and thin edges lose volume all the same: of_volume gives it back.
"""

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from mammosim.meshing.distance import NearestOnTriangles
from mammosim.meshing.edges import resized
from mammosim.meshing.lattice import POINT_MM, on_lattice
from mammosim.meshing.surface import Surface

Size = Callable[[np.ndarray], np.ndarray]
"""Edge length (n,) mm wanted at points (n, 3)."""

GROWTH = 1.6  # of the edges from one sweep to the next; more at once folds the surface at its rims
SWEEPS, FITTED_SWEEPS = 4, 5  # at full size
VOLUME_STEPS = 4  # of Newton's method; the first already leaves less than a thousandth
KEPT = 0.1  # weight of a vertex's own place, relative to the planes it is fitted to
# A given triangle belongs to the nearest of some vertices whose normal has at least this cosine with its own.
NEIGHBOURS, SAME_SIDE = 8, 0.3
TINY = 1e-12  # mm2, against division by the area of a triangle that has none


def remeshed(surface: Surface, size: Size) -> Surface:
    """The surface with edges of about size(points), smooth parts keeping their volume."""
    nearest = NearestOnTriangles(surface.corners())
    points, triangles = surface.points, surface.triangles
    for limit in _growing(surface, size):
        points, triangles = resized(points, triangles, np.minimum(size(points), limit))
        points = on_lattice(nearest(_relaxed(points, triangles))[0], POINT_MM)
    for _ in range(FITTED_SWEEPS):
        points, triangles = resized(points, triangles, size(points))
        points = on_lattice(_fitted(_relaxed(points, triangles), triangles, surface), POINT_MM)
    return Surface(on_lattice(_balanced(points, triangles, nearest), POINT_MM), triangles)


def of_volume(surface: Surface, volume_mm3: float, *, most_mm: float) -> Surface:
    """The surface moved along its normals, by the same distance d everywhere, until it encloses a volume V*.

    By Newton's method for V(d) = V*, where dV/dd = sum over triangles of area A . mean of their corners'
    normals; |d| is at most most_mm.
    """
    points, d = surface.points, 0.0
    normal = _vertex_normals(points, surface.triangles)
    for _ in range(VOLUME_STEPS):
        moved = Surface(points + d * normal, surface.triangles)
        area_normal, _ = _area_normals(moved.points, moved.triangles)
        slope = np.sum(area_normal * normal[surface.triangles].mean(axis=1))
        d = float(np.clip(d + (volume_mm3 - moved.volume()) / slope, -most_mm, most_mm))
    return Surface(on_lattice(points + d * normal, POINT_MM), surface.triangles)


def _growing(surface: Surface, size: Size) -> list[float]:
    """Largest edge length of each sweep, from the surface's own to the largest wanted."""
    corners = surface.corners()
    length = float(np.median(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1)))
    largest, limits = size(surface.points).max(), []
    while (length := length * GROWTH) < largest:
        limits.append(length)
    return limits + [np.inf] * SWEEPS


def _relaxed(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Vertices moved in their tangent plane to the area-weighted mean of the triangles around them."""
    area_normal, centre = _area_normals(points, triangles)
    area = np.maximum(np.linalg.norm(area_normal, axis=1, keepdims=True), TINY)
    at_corners = np.repeat(np.hstack([area, area * centre]), 3, axis=0)
    total, weighted = np.split(_sums(at_corners, triangles.ravel(), len(points)), [1], axis=1)
    normal = _vertex_normals(points, triangles)
    step = weighted / total - points
    return points + step - np.sum(step * normal, axis=1, keepdims=True) * normal


def _fitted(points: np.ndarray, triangles: np.ndarray, given: Surface) -> np.ndarray:
    """Vertices x where the planes of the given surface around them fit best (Valette et al. 2008).

    x minimises sum a (n . (x - c))^2 over the given triangles that are nearest to it, a their area, n their
    normal, c their centre; where these say nothing, it stays. So it lies on creases and corners.
    """
    area_normal, c = _area_normals(given.points, given.triangles)
    a = np.maximum(np.linalg.norm(area_normal, axis=1), TINY)
    n = area_normal / a[:, None]
    _, near = cKDTree(points).query(c, k=min(NEIGHBOURS, len(points)))
    same_side = np.sum(n[:, None] * _vertex_normals(points, triangles)[near], axis=2) > SAME_SIDE
    v = near[np.arange(len(near)), same_side.argmax(axis=1)]
    a_n_n = (a[:, None, None] * n[:, :, None] * n[:, None]).reshape(-1, 9)
    A = _sums(a_n_n, v, len(points)).reshape(-1, 3, 3)
    b = _sums((a * np.sum(n * (c - points[v]), axis=1))[:, None] * n, v, len(points))
    A += (KEPT * np.trace(A, axis1=1, axis2=2) + TINY)[:, None, None] * np.eye(3)
    return points + np.linalg.solve(A, b[..., None])[..., 0]


def _balanced(points: np.ndarray, triangles: np.ndarray, nearest: NearestOnTriangles) -> np.ndarray:
    """Vertices raised along their normal until the given surface lies on average as far above as below.

    Over a triangle the mean height of the given surface is 3/4 of that at its centre and 1/12 of that at each
    corner, exact for a quadratic surface. A vertex rises by the mean over the triangles around it.
    """
    area_normal, centre = _area_normals(points, triangles)
    area = np.maximum(np.linalg.norm(area_normal, axis=1), TINY)
    normal = _vertex_normals(points, triangles)
    at_centre = np.sum((nearest(centre)[0] - centre) * area_normal, axis=1) / area
    at_corners = np.sum((nearest(points)[0] - points) * normal, axis=1)[triangles].sum(axis=1)
    height = 3 / 4 * at_centre + 1 / 12 * at_corners
    weights = np.repeat(np.stack([area, area * height], axis=1), 3, axis=0)
    total, weighted = _sums(weights, triangles.ravel(), len(points)).T
    return points + (weighted / total)[:, None] * normal


def _vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3): means over the triangles around each vertex, weighted by area."""
    area_normal, _ = _area_normals(points, triangles)
    normal = _sums(np.repeat(area_normal, 3, axis=0), triangles.ravel(), len(points))
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), TINY)


def _area_normals(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outward normals (m, 3), as long as the triangle's area, and centres (m, 3)."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return np.cross(b - a, c - a) / 2, (a + b + c) / 3


def _sums(values: np.ndarray, vertex: np.ndarray, n: int) -> np.ndarray:
    """Sums (n, k) at each vertex of values (m, k) that belong to vertices (m,)."""
    return np.stack([np.bincount(vertex, weights=column, minlength=n) for column in values.T], axis=1)
