"""Exact lengths of all rays of a detector row at once, for rows parallel to an axis of the grid.

The source and a row along x span a plane, and all rays of the row cross the faces across y and z at the
same fractions t of their way: ray n is x(t) = xs + q_n t, q_n = q_0 + n dq. Between two such faces, ta to tb,
a ray stays in one line of voxels along x, where the material changes at faces X only. With p = X - xs, the
share of ta..tb that ray n spends beyond X is

    g_n = 0  below q_n = p/tb,   tb - p/q_n  between,   tb - ta  above p/ta      (p > 0; mirrored for p < 0)

a step along the row, but for the few rays that cross X between ta and tb. The steps are added as differences
along n and summed once per row: the cost is the number of changes of material, not rays times voxels.
What passes along the rays is summed over many energies at once, sum_E w exp(-sum_m mu_m(E) L_m).
"""

import math
from typing import NamedTuple

import numpy as np

from mammosim.io.compiled import njit, prange
from mammosim.xray.phantom import Phantom

LOG2_E = 1.4426950408889634
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # their sum is ln 2
ROUNDING = 1.5 * 2.0**52  # a number plus this is rounded, with its integer in the lowest bits
DEEPEST = 690.0  # exp(-690) = 1e-300, the smallest that is told from zero
# 1/k! of the series of exp(r), |r| <= ln(2)/2: the first term left out is 2e-16
C = tuple(1.0 / float(np.prod(np.arange(1.0, k + 1))) for k in range(13))
NO_T = 1e-12  # of the way; stands for t = 0 in p/t


class Lines(NamedTuple):
    """Where the material changes along each line of voxels, and the grid of the lines.

    first: (n_line + 1,) the changes of line j + k ny are first[line] to first[line + 1].
    face: (n_change,) X in mm; after: (n_change,) uint8 material beyond it.
    low, spacing: (3,) mm of the grid in (x, y, z); ny, nz: lines along y and z.
    """

    first: np.ndarray
    face: np.ndarray
    after: np.ndarray
    low: np.ndarray
    spacing: np.ndarray
    ny: int
    nz: int


def lines_along(phantom: Phantom, axis: int) -> Lines:
    """The lines of a phantom along one axis (0, 1, 2), which is called x here; y, z are the others."""
    others = [a for a in range(3) if a != axis]
    order = (axis, *others)
    index = np.ascontiguousarray(phantom.index.transpose([2 - a for a in order[::-1]]))
    low, spacing = phantom.low[list(order)], phantom.grid.spacing[list(order)]
    lines = index.reshape(-1, index.shape[2])
    first = np.concatenate([[0], np.cumsum(_changes(lines))])
    place, after = _filled(lines, first)
    return Lines(first, low[0] + spacing[0] * place, after, low, spacing, index.shape[1], index.shape[0])


def no_lines() -> Lines:
    """A grid of air only."""
    return Lines(np.zeros(2, np.int64), np.zeros(0), np.zeros(0, np.uint8), -np.ones(3), np.ones(3), 1, 1)


@njit(cache=True)
def _changes(lines: np.ndarray) -> np.ndarray:
    """Changes of material (n_line,) along lines (n_line, nx), from air and to air at the ends."""
    n_line, nx = lines.shape
    changes = np.zeros(n_line, np.int64)
    for line in range(n_line):
        found = 0
        for i in range(1, nx):
            found += lines[line, i] != lines[line, i - 1]
        changes[line] = found + (lines[line, 0] != 0) + (lines[line, nx - 1] != 0)
    return changes


@njit(cache=True)
def _filled(lines: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (n_change,), counted from the lower end of the line, and the material (n_change,) beyond each."""
    n_line, nx = lines.shape
    place, after = np.empty(first[-1], np.int64), np.empty(first[-1], np.uint8)
    for line in range(n_line):
        at = first[line]
        if at == first[line + 1]:
            continue
        before = 0
        for i in range(nx):
            if lines[line, i] != before:
                before = lines[line, i]
                place[at], after[at] = i, before
                at += 1
        if before != 0:
            place[at], after[at] = nx, 0
    return place, after


@njit(cache=True)
def passed(
    lengths: np.ndarray, mu: np.ndarray, weights: np.ndarray, into: np.ndarray, work: np.ndarray
) -> None:
    """Adds to into (n_weight, n_ray) what passes; lengths (n_material, n_ray) mm, mu (n_material, n_energy).

    weights (n_weight, n_energy); work (2, n_ray) is overwritten.
    The exponential is exp(-x) = 2^n exp(r), written as plain loops over rays that compile to vectors.
    """
    n_material, n_energy = mu.shape
    n_ray = lengths.shape[1]
    x, power = work[0], work[1]
    bits = power.view(np.int64)
    for e in range(n_energy):
        mu_e = mu[0, e]
        for i in range(n_ray):
            x[i] = mu_e * lengths[0, i]
        for m in range(1, n_material):
            mu_e = mu[m, e]
            for i in range(n_ray):
                x[i] += mu_e * lengths[m, i]
        for i in range(n_ray):
            y = -min(x[i], DEEPEST)
            power[i] = y * LOG2_E + ROUNDING
            n = power[i] - ROUNDING
            r = (y - n * LN2_HIGH) - n * LN2_LOW
            s = C[12]
            s = s * r + C[11]
            s = s * r + C[10]
            s = s * r + C[9]
            s = s * r + C[8]
            s = s * r + C[7]
            s = s * r + C[6]
            s = s * r + C[5]
            s = s * r + C[4]
            s = s * r + C[3]
            s = s * r + C[2]
            s = s * r + 1.0
            x[i] = s * r + 1.0
        for i in range(n_ray):
            bits[i] = (bits[i] + 1023) << 52  # the bits of 2^n
        for i in range(n_ray):
            x[i] *= power[i]
        for w in range(len(weights)):
            weight = weights[w, e]
            for i in range(n_ray):
                into[w, i] += weight * x[i]


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
