"""Exact lengths of all rays of a detector row at once, for rows parallel to an axis of the grid.

The source and a row along x span a plane, and all rays of the row cross the faces across y and z at the
same fractions t of their way: ray n is x(t) = xs + q_n t, q_n = q_0 + n dq. Between two such faces, ta to tb,
a ray stays in one line of voxels along x, where the material changes at faces X only. With p = X - xs, the
share of ta..tb that ray n spends beyond X is

    g_n = 0  below q_n = p/tb,   tb - p/q_n  between,   tb - ta  above p/ta      (p > 0; mirrored for p < 0)

a step along the row, but for the few rays that cross X between ta and tb. The steps are added as differences
along n and summed once per row: the cost is the number of changes of material, not rays times voxels.
"""

import math
from typing import NamedTuple

import numpy as np

from mammosim.io.compiled import njit, prange
from mammosim.xray.beer_lambert import passed
from mammosim.xray.lines import Lines

NO_T = 1e-12  # of the way; stands for t = 0 in p/t


class Rows(NamedTuple):
    """Rows of rays along x, in the axes of Lines: ray n of row r ends at corner + (n+1/2) step x + r across.

    source, corner, across: (3,) mm, across at right angles to x; step > 0 mm; height: of the source, mm.
    """

    source: np.ndarray
    corner: np.ndarray
    across: np.ndarray
    step: float
    height: float
    n_row: int
    n_ray: int


@njit(cache=True)
def lengths_in_row(lines: Lines, rows: Rows, row: float, lengths: np.ndarray) -> None:
    """Sets lengths (n_material, n_ray) mm of the rays of one row, r = row; [0] is air, outside, too."""
    y, z = rows.corner[1] + row * rows.across[1], rows.corner[2] + row * rows.across[2]
    n_material, n_ray = lengths.shape
    steps = np.zeros((n_material, n_ray + 1))
    q0 = rows.corner[0] + 0.5 * rows.step - rows.source[0]
    add_shares(lines, rows.source, y, z, (q0, rows.step), steps)
    across2 = (y - rows.source[1]) ** 2 + (z - rows.source[2]) ** 2
    whole = np.empty(n_ray)
    for n in range(n_ray):
        q = q0 + n * rows.step
        whole[n] = math.sqrt(across2 + q * q)
        lengths[0, n] = whole[n]
    for m in range(1, n_material):
        share = 0.0
        for n in range(n_ray):
            share += steps[m, n]
            lengths[m, n] = share * whole[n]
            lengths[0, n] -= lengths[m, n]


@njit(cache=True, parallel=True)
def row_lengths(lines: Lines, rows: Rows, n_material: int) -> np.ndarray:
    """Lengths (n_material, n_row, n_ray) mm of the rays to the middle of each row."""
    n_row, n_ray = rows.n_row, rows.n_ray
    found = np.empty((n_material, n_row, n_ray))
    for r in prange(n_row):
        lengths = np.empty((n_material, n_ray))
        lengths_in_row(lines, rows, r + 0.5, lengths)
        found[:, r, :] = lengths
    return found


@njit(cache=True, parallel=True)
def row_images(lines: Lines, rows: Rows, samples: int, mu: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Images (n_weight, n_row, n_ray/samples): sum_E w exp(-sum_m mu_m L_m) cos(theta)/r^2, mean of rays.

    rows holds samples rays per pixel; samples rows are traced for each of its rows.
    mu (n_material, n_energy) 1/mm; weights (n_weight, n_energy).
    """
    n_row, n_ray = rows.n_row, rows.n_ray
    n_weight = len(weights)
    images = np.zeros((n_weight, n_row, n_ray // samples))
    for r in prange(n_row):
        lengths, passing = np.empty((len(mu), n_ray)), np.empty((n_weight, n_ray))
        work = np.empty((2, n_ray))
        for a in range(samples):
            lengths_in_row(lines, rows, r + (a + 0.5) / samples, lengths)
            passing[:] = 0.0
            passed(lengths, mu, weights, passing, work)
            for n in range(n_ray):
                R = 0.0
                for m in range(len(mu)):
                    R += lengths[m, n]
                share = rows.height / (R * R * R * samples * samples)
                for w in range(n_weight):
                    images[w, r, n // samples] += share * passing[w, n]
    return images


@njit(cache=True)
def add_shares(
    lines: Lines, source: np.ndarray, y: float, z: float, q: tuple[float, float], steps: np.ndarray
) -> None:
    """Adds to steps (n_material, n_ray + 1) the differences along n of the share of the way in each material.

    source (3,), and y, z of the row; q = (q_0, dq > 0) of x(t) = xs + (q_0 + n dq) t, mm. Row 0 is not used.
    """
    ny, nz = lines.ny, lines.nz
    y_low, z_low = lines.low[1] - source[1], lines.low[2] - source[2]
    hy, hz = lines.spacing[1], lines.spacing[2]
    dy, dz = y - source[1], z - source[2]
    t, t_out = _within(y_low, y_low + ny * hy, dy, 0.0, 1.0)
    t, t_out = _within(z_low, z_low + nz * hz, dz, t, t_out)
    if t >= t_out:
        return
    j = min(max(math.floor((t * dy - y_low) / hy), 0), ny - 1)
    k = min(max(math.floor((t * dz - z_low) / hz), 0), nz - 1)
    step_j, step_k = (1 if dy > 0 else -1), (1 if dz > 0 else -1)
    while t < t_out and 0 <= j < ny and 0 <= k < nz:
        ty = (y_low + (j + (dy > 0)) * hy) / dy if dy != 0.0 else 2.0
        tz = (z_low + (k + (dz > 0)) * hz) / dz if dz != 0.0 else 2.0
        t_next = min(ty, tz, t_out)
        if t_next > t:
            _add_line(lines, j + k * ny, (t, t_next), source[0], q, steps)
            t = t_next
        if ty <= tz:
            j += step_j
        else:
            k += step_k


@njit(cache=True)
def _within(low: float, high: float, d: float, t_in: float, t_out: float) -> tuple[float, float]:
    """The part of t_in..t_out where low <= t d < high."""
    if d == 0.0:
        return (t_in, t_out) if low <= 0.0 < high else (1.0, 0.0)
    return max(t_in, min(low / d, high / d)), min(t_out, max(low / d, high / d))


@njit(cache=True)
def _add_line(
    lines: Lines, line: int, part: tuple[float, float], xs: float, q: tuple[float, float], steps: np.ndarray
) -> None:
    """Adds the shares that the rays spend in one line of voxels in the part ta to tb of their way."""
    (ta, tb), (q0, dq) = part, q
    n = steps.shape[1] - 1
    per_ta, per_tb = 1 / max(ta, NO_T), 1 / tb
    before = 0
    for change in range(lines.first[line], lines.first[line + 1]):
        p, after = lines.face[change] - xs, lines.after[change]
        q_none, q_all = (p * per_tb, p * per_ta) if p > 0 else (p * per_ta, p * per_tb)
        first = int(min(max(math.ceil((q_none - q0) / dq), 0.0), n))
        full = int(min(max(math.ceil((q_all - q0) / dq), 0.0), n))
        for i in range(first, full):
            t_face = p / (q0 + i * dq)
            g = tb - t_face if p > 0 else t_face - ta
            steps[after, i] += g
            steps[after, i + 1] -= g
            steps[before, i] -= g
            steps[before, i + 1] += g
        steps[after, full] += tb - ta
        steps[before, full] -= tb - ta
        before = after
