"""What a ray meets on its way to the detector, or out of the body: exact optical depths, compiled."""

import math

import numpy as np

from mammosim.xray.random_stream import compiled
from mammosim.xray.source_sampling import Triple
from mammosim.xray.transport_step import (
    LOST_AFTER_MM,
    MIXED,
    Body,
    faces_of_cell,
    inverse,
    next_box,
    next_cell,
)

EVEN = 1e-6  # below, exp(-x) is 1 - x to rounding
T, TAU, SCATTERS, MATERIAL = 0, 1, 2, 3  # columns of a path


def longest_path(body: Body) -> int:
    """No ray through the body has more steps."""
    voxels = np.array(body.blocks.shape) * np.array(body.voxels.shape[1:])
    return int(2 * voxels.sum() + 4 * len(body.boxes) + 8)


@compiled
def stepped(path: np.ndarray, n: int, t: float, mu: np.ndarray, material: int) -> int:
    """One more step of the path, up to t, through a material; how many there are."""
    dt = t - path[n, T]
    path[n + 1, T] = t
    path[n + 1, TAU] = path[n, TAU] + mu[material, 0] * dt
    path[n + 1, SCATTERS] = path[n, SCATTERS] + mu[material, 1] * dt
    path[n + 1, MATERIAL] = material
    return n + 1


@compiled
def traversed(body: Body, mu: np.ndarray, t_seen: float, p: Triple, d: Triple, path: np.ndarray) -> int:
    """Steps of a ray from p along d to the detector at t_seen, or out of the body and through the air.

    mu (n_material, 2) 1/mm: total, and scattering only. path (n + 1, 4): after each step the distance, the
    optical depth, that of scattering only, and the material of the step; a first row of zeros.
    """
    ix, iy, iz = inverse(d[0]), inverse(d[1]), inverse(d[2])
    nz, ny, nx = body.blocks.shape
    px, py, pz = p[0] - body.low[0], p[1] - body.low[1], p[2] - body.low[2]
    path[0] = 0.0
    n, t = 0, 0.0
    while True:
        t_box, t_out = next_box(body.boxes, t, p[0], p[1], p[2], ix, iy, iz)
        t_end = min(t_seen, t_box)
        if t_end == math.inf:
            t_end = t + LOST_AFTER_MM
        if t_end > t:
            n = stepped(path, n, t_end, mu, 0)
        t = t_end
        if t < t_box or t_seen <= t_box:
            return n
        t_stop = min(t_out, t_seen)
        at = (px + t * d[0], py + t * d[1], pz + t * d[2])
        cell, step, far, width = faces_of_cell(at, (ix, iy, iz), body.block_mm, (nx, ny, nz), t)
        while t < t_stop:
            i, j, k = cell
            t_face = min(far[0], far[1], far[2], t_stop)
            material = body.single[body.blocks[k, j, i]]
            if material != MIXED:
                n = stepped(path, n, t_face, mu, material)
            else:
                n = through_tile(body, mu, i, j, k, t_face, px, py, pz, d, ix, iy, iz, path, n)
            t = t_face
            cell, far = next_cell(cell, step, far, width, (nx, ny, nz))
        if t >= t_seen:
            return n


@compiled
def through_tile(
    body: Body, mu: np.ndarray, i: int, j: int, k: int, t_face: float, px: float, py: float, pz: float,
    d: Triple, ix: float, iy: float, iz: float, path: np.ndarray, n: int,
) -> int:  # fmt: skip
    """Steps through the voxels of a mixed block, up to t_face."""
    _, sz, sy, sx = body.voxels.shape
    tile = body.tiles[k, j, i]
    t = path[n, T]
    hx, hy, hz = body.block_mm[0] / sx, body.block_mm[1] / sy, body.block_mm[2] / sz
    at = (
        px + t * d[0] - i * body.block_mm[0],
        py + t * d[1] - j * body.block_mm[1],
        pz + t * d[2] - k * body.block_mm[2],
    )
    voxel, step, far, width = faces_of_cell(at, (ix, iy, iz), (hx, hy, hz), (sx, sy, sz), t)
    while True:
        a, b, c = voxel
        t = min(far[0], far[1], far[2], t_face)
        n = stepped(path, n, t, mu, body.voxels[tile, c, b, a])
        if t >= t_face:
            return n
        voxel, far = next_cell(voxel, step, far, width, (sx, sy, sz))


@compiled
def scattering_point(path: np.ndarray, n: int, u: float, kappa: float) -> tuple[float, float, int, float]:
    """A place to scatter at: its distance, optical depth and material, and one over its density p(s).

    s, the depth of scattering so far, is drawn by u from p(s) ~ exp(-kappa s tau/S), with tau, S of the whole
    path: kappa is 0 where all places promise the same, and 1 where only the attenuation up to there counts.
    """
    S = path[n, SCATTERS]
    k = kappa * path[n, TAU] / S
    whole = 1 - math.exp(-k * S)
    even = k * S < EVEN
    s = u * S if even else -math.log(1 - u * whole) / k
    low, high = 0, n
    while high - low > 1:
        middle = (low + high) // 2
        if path[middle, SCATTERS] <= s:
            low = middle
        else:
            high = middle
    width = path[high, SCATTERS] - path[low, SCATTERS]
    share = min((s - path[low, SCATTERS]) / width, 1.0) if width > 0 else 1.0
    t = path[low, T] + share * (path[high, T] - path[low, T])
    tau = path[low, TAU] + share * (path[high, TAU] - path[low, TAU])
    return t, tau, int(path[high, MATERIAL]), S if even else whole / (k * math.exp(-k * s))


@compiled
def ends(path: np.ndarray, n: int) -> tuple[float, float]:
    """Distances at which a path first enters, and last leaves, what is not air; 0 when it meets only air."""
    top, bottom = 0.0, 0.0
    for i in range(n, 0, -1):
        if path[i, MATERIAL] != 0:
            top = path[i - 1, T]
            bottom = max(bottom, path[i, T])
    return top, bottom
