"""One step of a photon through the body and the air around it, to its next collision, compiled.

A step ends where its optical depth, -ln(u), is used up. Outside all boxes there is nothing but air. Inside
a box the voxels are gathered in blocks, each with the largest mu M of its materials: Woodcock tracking stops
at optical depths of M, and a stop in material m is real with probability mu_m/M. In a block of one material
every stop is real.
"""

import math
from typing import NamedTuple

import numpy as np

from mammosim.xray.interactions import Matter, between
from mammosim.xray.random_stream import compiled, exponential, uniform
from mammosim.xray.source_sampling import FLAT, Triple

# ASSUME: photons that cross half a metre of air without meeting body or detector do not come back.
LOST_AFTER_MM = 500.0
NEAR_MM = 1e-7  # a face nearer than this has been reached
Cell = tuple[int, int, int]  # along x, y, z
MET, SEEN, LOST = 0, 1, 2  # what ends a step
MIXED = -1  # a block of several materials


class Body(NamedTuple):
    """Blocks of voxels, and the boxes around all that are not air.

    low (3,) mm, block_mm (3,), per_mm (3,) voxels per mm, in (x, y, z);
    blocks (bz, by, bx) uint16 kind of each block; majorant (n_energy, n_kind) 1/mm;
    single (n_kind,) the material of blocks of one material, else MIXED;
    tiles (bz, by, bx): where the voxels of a mixed block are; voxels (n_mixed, sz, sy, sx) uint8 material;
    boxes (n_box, 6): low xyz, high xyz, mm, on faces of blocks.
    """

    low: Triple
    block_mm: Triple
    per_mm: Triple
    blocks: np.ndarray
    majorant: np.ndarray
    single: np.ndarray
    tiles: np.ndarray
    voxels: np.ndarray
    boxes: np.ndarray


@compiled
def slab(low: float, high: float, position: float, inverse: float) -> tuple[float, float]:
    """Distances to entry and exit of low..high along one axis, with 1/direction."""
    a, b = (low - position) * inverse, (high - position) * inverse
    return (a, b) if a < b else (b, a)


@compiled
def crossing(
    boxes: np.ndarray, i: int, x: float, y: float, z: float, ix: float, iy: float, iz: float
) -> tuple[float, float]:
    """Distances at which the ray enters and leaves box i of (n_box, 6); missed when the first is larger."""
    x0, x1 = slab(boxes[i, 0], boxes[i, 3], x, ix)
    y0, y1 = slab(boxes[i, 1], boxes[i, 4], y, iy)
    z0, z1 = slab(boxes[i, 2], boxes[i, 5], z, iz)
    return max(x0, y0, z0), min(x1, y1, z1)


@compiled
def inverse(d: float) -> float:
    """1/d, with directions in a plane taken as nearly so."""
    return 1 / d if abs(d) > FLAT else math.copysign(1 / FLAT, d)


@compiled
def next_box(
    boxes: np.ndarray, t: float, x: float, y: float, z: float, ix: float, iy: float, iz: float
) -> tuple[float, float]:
    """Where the ray enters (at t or later) and leaves the first box after t; infinite when there is none."""
    first, last = math.inf, math.inf
    for i in range(len(boxes)):
        t_in, t_out = crossing(boxes, i, x, y, z, ix, iy, iz)
        if t_in < t_out and t_out > t + NEAR_MM and t_in < first:
            first, last = t_in, t_out
    return max(first, t), last


@compiled
def faces(at: float, inverse: float, size: float, n: int) -> tuple[int, int, float, float]:
    """Along one axis: the block at a place (mm from low), its neighbour, to its far face, between faces."""
    i = min(max(int(at / size), 0), n - 1)
    if inverse > 0:
        return i, 1, ((i + 1) * size - at) * inverse, size * inverse
    return i, -1, (i * size - at) * inverse, -size * inverse


@compiled
def faces_of_cell(
    at: Triple, inverses: Triple, size: Triple, shape: Cell, t: float
) -> tuple[Cell, Cell, Triple, Triple]:
    """The cell at a place (mm from low) that the ray reaches at t, the way to the next along each axis, and
    the distances from the ray's start to its far faces, and between faces."""
    i, step_i, tx, wx = faces(at[0], inverses[0], size[0], shape[0])
    j, step_j, ty, wy = faces(at[1], inverses[1], size[1], shape[1])
    k, step_k, tz, wz = faces(at[2], inverses[2], size[2], shape[2])
    return (i, j, k), (step_i, step_j, step_k), (tx + t, ty + t, tz + t), (wx, wy, wz)


@compiled
def next_cell(cell: Cell, step: Cell, t: Triple, width: Triple, shape: Cell) -> tuple[Cell, Triple]:
    """The cell beyond the nearest far face, or the grid's last, and the distances to its far faces."""
    (i, j, k), (tx, ty, tz) = cell, t
    if tx <= ty and tx <= tz:
        return (min(max(i + step[0], 0), shape[0] - 1), j, k), (tx + width[0], ty, tz)
    if ty <= tz:
        return (i, min(max(j + step[1], 0), shape[1] - 1), k), (tx, ty + width[1], tz)
    return (i, j, min(max(k + step[2], 0), shape[2] - 1)), (tx, ty, tz + width[2])


@compiled
def within(at: float, block_mm: float, block: int, per_mm: float, n: int) -> int:
    """Along one axis: which of a block's n voxels is at a place, or nearest to it."""
    return min(max(int((at - block * block_mm) * per_mm), 0), n - 1)


@compiled
def transport_step(
    body: Body, matter: Matter, row: int, share: float, t_seen: float, x: float, y: float, z: float,
    dx: float, dy: float, dz: float, state: np.ndarray,
) -> tuple[float, int, int, float]:  # fmt: skip
    """A step: its length, what ends it, the material met, and a number even in [0, mu of it)."""
    ix, iy, iz = inverse(dx), inverse(dy), inverse(dz)
    mu_air = between(matter.mu, row, share, 0, 0)
    _, sz, sy, sx = body.voxels.shape
    left = exponential(state)  # optical depth
    t = 0.0
    while True:
        t_box, t_out = next_box(body.boxes, t, x, y, z, ix, iy, iz)
        t_end = min(t_seen, t_box)
        if t_end == math.inf:
            t_end = t + LOST_AFTER_MM
        depth = mu_air * (t_end - t)
        if left < depth:
            return t + left / mu_air, MET, 0, mu_air * uniform(state)
        left -= depth
        t = t_end
        if t < t_box or t_seen <= t_box:
            return t, SEEN if t_seen <= t else LOST, 0, 0.0

        t_stop = min(t_out, t_seen)
        px, py, pz = x - body.low[0], y - body.low[1], z - body.low[2]
        nz, ny, nx = body.blocks.shape
        at = (px + t * dx, py + t * dy, pz + t * dz)
        cell, step, far, width = faces_of_cell(at, (ix, iy, iz), body.block_mm, (nx, ny, nz), t)
        while True:
            i, j, k = cell
            kind = body.blocks[k, j, i]
            M = body.majorant[row, kind]
            M += share * (body.majorant[row + 1, kind] - M)
            t_face = min(far[0], far[1], far[2], t_stop)
            depth = M * (t_face - t)
            while left < depth:
                t += left / M
                material = body.single[kind]
                v = M * uniform(state)
                if material != MIXED:
                    return t, MET, material, v
                a = within(px + t * dx, body.block_mm[0], i, body.per_mm[0], sx)
                b = within(py + t * dy, body.block_mm[1], j, body.per_mm[1], sy)
                c = within(pz + t * dz, body.block_mm[2], k, body.per_mm[2], sz)
                material = body.voxels[body.tiles[k, j, i], c, b, a]
                if v < between(matter.mu, row, share, material, 0):
                    return t, MET, material, v
                left = exponential(state)
                depth = M * (t_face - t)
            left -= depth
            t = t_face
            if t >= t_stop:
                break
            cell, far = next_cell(cell, step, far, width, (nx, ny, nz))
        if t >= t_seen:
            return t, SEEN, 0, 0.0
