"""Shaded pictures of surfaces: orthographic, with a depth buffer, so that nothing behind shows through."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from scipy.ndimage import label

from mammosim.io.compiled import njit

# Light from over the viewer's left shoulder: towards the light, in (right, up, viewer).
LIGHT = np.array([-0.45, 0.6, 0.66])
AMBIENT, DIFFUSE, SPECULAR, SHININESS = 0.38, 0.62, 0.16, 24
SUPERSAMPLING = 2
COLUMNS = 900  # of a picture half as wide as the page, at 300 per inch
SPECK = 1e-3  # of the largest piece of a picture
EDGE = 0.6  # of the light, at edges between parts


@dataclass(frozen=True)
class Camera:
    """Axes of the picture: right, up and towards the viewer, (3,) unit vectors of the patient frame."""

    right: np.ndarray
    up: np.ndarray
    towards: np.ndarray

    @classmethod
    def at(cls, azimuth_deg: float, elevation_deg: float, *, up: str = "superior") -> "Camera":
        """A viewer in front of the patient, gone `azimuth_deg` to the patient's left, then up.

        up: 'superior', as the patient stands; or 'posterior', as she lies prone, seen from her feet.
        """
        a, e = np.radians([azimuth_deg, elevation_deg])
        if up == "superior":
            vertical, ahead, left = np.eye(3)[2], -np.eye(3)[1], np.eye(3)[0]
        else:
            vertical, ahead, left = np.eye(3)[1], -np.eye(3)[2], np.eye(3)[0]
        towards = np.cos(e) * (np.cos(a) * ahead + np.sin(a) * left) + np.sin(e) * vertical
        right = np.cross(vertical, towards)
        right /= np.linalg.norm(right)
        return cls(right, np.cross(towards, right), towards)

    def project(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) mm: right, up, and towards the viewer."""
        return points @ np.stack([self.right, self.up, self.towards], axis=1)


@dataclass(frozen=True)
class Solid:
    """Triangles (m, 3) of points (n, 3) mm, outward; colours (m, 3) RGB in [0, 1].

    smooth: shade as a curved surface, else each triangle flat; lit: shade at all. opacity in (0, 1].
    parts (m,): the part that each triangle belongs to, edges are drawn between parts; None: no edges.
    inside (n,): what is shown ends where this, linear in each triangle, falls below zero; None: all is shown.
    """

    points: np.ndarray
    triangles: np.ndarray
    colours: np.ndarray
    smooth: bool = True
    lit: bool = True
    opacity: float = 1.0
    parts: np.ndarray | None = None
    inside: np.ndarray | None = None

    @classmethod
    def of(cls, points: np.ndarray, triangles: np.ndarray, colour: str, **options: Any) -> "Solid":
        """One colour for all; options: smooth, lit, opacity, parts, inside."""
        return cls(points, triangles, np.tile(to_rgb(colour), (len(triangles), 1)), **options)


@dataclass(frozen=True)
class Picture:
    """rgba (rows, columns, 4), first row at the top; extent (left, right, bottom, top) mm of the camera."""

    rgba: np.ndarray
    extent: tuple[float, float, float, float]

    def show(self, ax: Axes) -> None:
        """Draw it on white, in mm of the camera's right and up."""
        alpha = self.rgba[..., 3:]
        on_white = self.rgba[..., :3] * alpha + 1 - alpha
        ax.imshow(on_white, extent=self.extent, interpolation="antialiased")
        ax.set_aspect("equal")


def render(
    solids: tuple[Solid, ...],
    camera: Camera,
    *,
    columns: int = COLUMNS,
    extent: tuple[float, float, float, float] | None = None,
) -> Picture:
    """A picture of solids, the opaque ones first; `extent` in mm of the camera, by default all of them."""
    xyz = np.vstack(
        [camera.project(s.points[s.inside >= 0] if s.inside is not None else s.points) for s in solids]
    )
    (x0, y0, _), (x1, y1, _) = xyz.min(0) - 4, xyz.max(0) + 4
    left, right, bottom, top = extent or (x0, x1, y0, y1)
    n = columns * SUPERSAMPLING
    pixel = (right - left) / n
    shape = (max(round((top - bottom) / pixel / SUPERSAMPLING), 1) * SUPERSAMPLING, n)
    rgba, depth = np.zeros((*shape, 4), np.float32), np.full(shape, -np.inf)
    for solid in sorted(solids, key=lambda s: -s.opacity):
        seen = camera.project(solid.points)
        image = np.stack([(seen[:, 0] - left) / pixel, (top - seen[:, 1]) / pixel, seen[:, 2]], axis=1)
        front = depth.copy()
        triangle, b = np.full(shape, -1, np.int32), np.zeros((*shape, 3), np.float32)
        level = np.ones(len(image)) if solid.inside is None else solid.inside
        _fill(image, solid.triangles, level, front, triangle, b)
        hit = triangle >= 0
        colour = _shaded(solid, camera, triangle[hit], b[hit])
        if solid.parts is not None:
            colour[_between_parts(triangle, solid.parts)[hit]] *= EDGE
        if solid.opacity == 1:
            rgba[hit, :3], rgba[hit, 3], depth = colour, 1, front
        else:
            _lay_over(rgba, hit, colour, solid.opacity)
    rgba[_specks(rgba[..., 3] > 0)] = 0
    _draw_outlines(rgba, depth, pixel)
    return Picture(_downsampled(rgba), (left, right, bottom, top))


def _lay_over(rgba: np.ndarray, hit: np.ndarray, colour: np.ndarray, opacity: float) -> None:
    """Colours (k, 3) that can be seen through over the samples that are hit (rows, columns)."""
    below = np.where(rgba[hit, 3:], rgba[hit, :3], 1.0)
    rgba[hit, :3] = opacity * colour + (1 - opacity) * below
    rgba[hit, 3] = np.maximum(rgba[hit, 3], opacity)


def vertex_normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3): the mean over the triangles around each point, by area."""
    normals = np.zeros_like(points)
    p = points[triangles]
    faces = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    np.add.at(normals, triangles.ravel(), np.repeat(faces, 3, axis=0))
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def _shaded(solid: Solid, camera: Camera, triangle: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Colours (k, 3) of visible samples: ambient, diffuse, and a highlight of the light."""
    if not solid.lit:
        return solid.colours[triangle]
    if solid.smooth:
        at_nodes = camera.project(vertex_normals(solid.points, solid.triangles)).astype(np.float32)
        n = np.einsum("kc,kcd->kd", b, at_nodes[solid.triangles[triangle]])
        n /= np.sqrt(np.maximum(np.einsum("kd,kd->k", n, n), 1e-12))[:, None]
        diffuse, highlight = _light(n)
    else:
        corners = solid.points[solid.triangles]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-12)
        diffuse, highlight = (each[triangle] for each in _light(camera.project(flat)))
    return np.clip(solid.colours[triangle] * diffuse[:, None] + highlight[:, None], 0, 1)


def _light(n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Diffuse light and highlight (k,) of unit normals (k, 3) of the camera."""
    light = LIGHT / np.linalg.norm(LIGHT)
    half = light + np.array([0, 0, 1])
    diffuse = AMBIENT + DIFFUSE * np.clip((n @ light + 0.25) / 1.25, 0, 1)
    return diffuse, SPECULAR * np.clip(n @ half / np.linalg.norm(half), 0, 1) ** SHININESS


def _specks(seen: np.ndarray) -> np.ndarray:
    """Samples of pieces that are next to nothing: a rim that is seen edge on leaves such slivers."""
    pieces, _ = label(seen, np.ones((3, 3)))
    size = np.bincount(pieces.ravel())
    size[0] = 0
    return seen & (size[pieces] < SPECK * size.max())


def _between_parts(triangle: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Samples (rows, columns) whose right or lower neighbour is seen on another part."""
    part = np.where(triangle >= 0, parts[triangle], -1)
    edge = np.zeros(part.shape, bool)
    edge[:, :-1] |= (part[:, 1:] != part[:, :-1]) & (part[:, 1:] >= 0)
    edge[:-1] |= (part[1:] != part[:-1]) & (part[1:] >= 0)
    return edge


def _draw_outlines(rgba: np.ndarray, depth: np.ndarray, pixel: float) -> None:
    """Darken where the depth jumps by more than 3 mm: silhouettes against what is behind."""
    solid = np.where(np.isfinite(depth), depth, -1e6)
    jump = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        step = np.abs(np.diff(solid, axis=axis)) > 3 + 4 * pixel
        pad = [(0, 1) if a == axis else (0, 0) for a in (0, 1)]
        jump |= np.pad(step, pad)
    rgba[jump & (rgba[..., 3] > 0), :3] *= 0.45


def _downsampled(rgba: np.ndarray) -> np.ndarray:
    """Means over SUPERSAMPLING x SUPERSAMPLING samples, colours weighted by opacity."""
    s = SUPERSAMPLING
    rgba[..., :3] *= rgba[..., 3:]
    mean = np.zeros((rgba.shape[0] // s, rgba.shape[1] // s, 4), np.float32)
    for i in range(s):
        for j in range(s):
            mean += rgba[i::s, j::s] / (s * s)
    mean[..., :3] /= np.maximum(mean[..., 3:], 1e-9)
    return np.clip(mean, 0, 1)


@njit(cache=True)
def _fill(
    image: np.ndarray,
    triangles: np.ndarray,
    level: np.ndarray,
    depth: np.ndarray,
    triangle: np.ndarray,
    b: np.ndarray,
) -> None:
    """Depth-buffer the front sides where level >= 0: image (n, 3) are columns, rows, towards the viewer."""
    rows, columns = depth.shape
    for t in range(len(triangles)):
        p, q, r = image[triangles[t, 0]], image[triangles[t, 1]], image[triangles[t, 2]]
        # Rows point down, so a triangle that turns left as seen has a negative area here.
        area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        if area >= 0:
            continue
        i0 = max(int(np.floor(min(p[1], q[1], r[1]))), 0)
        i1 = min(int(np.ceil(max(p[1], q[1], r[1]))), rows - 1)
        j0 = max(int(np.floor(min(p[0], q[0], r[0]))), 0)
        j1 = min(int(np.ceil(max(p[0], q[0], r[0]))), columns - 1)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                x, y = j + 0.5, i + 0.5
                u = ((q[0] - x) * (r[1] - y) - (q[1] - y) * (r[0] - x)) / area
                v = ((r[0] - x) * (p[1] - y) - (r[1] - y) * (p[0] - x)) / area
                w = 1 - u - v
                if u < 0 or v < 0 or w < 0:
                    continue
                shown = u * level[triangles[t, 0]] + v * level[triangles[t, 1]] + w * level[triangles[t, 2]]
                if shown >= 0:
                    z = u * p[2] + v * q[2] + w * r[2]
                    if z > depth[i, j]:
                        depth[i, j], triangle[i, j] = z, t
                        b[i, j, 0], b[i, j, 1], b[i, j, 2] = u, v, w
