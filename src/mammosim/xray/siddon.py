"""Exact lengths of rays in voxels (Siddon 1985, Med Phys 12:252; stepping after Amanatides & Woo 1987)."""

import math

import numpy as np

from mammosim.io.compiled import njit, prange


@njit(cache=True)
def material_lengths(
    index: np.ndarray,
    low: np.ndarray,
    spacing: np.ndarray,
    source: np.ndarray,
    target: np.ndarray,
    lengths: np.ndarray,
) -> None:
    """Adds to lengths (n_material,) the mm of source -> target in each material; what is outside adds to [0].

    index (nz, ny, nx) uint8; low (3,) lower corner of the grid; spacing (3,); all in (x, y, z), mm.
    """
    nz, ny, nx = index.shape
    dx, dy, dz = target[0] - source[0], target[1] - source[1], target[2] - source[2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    dx, dy, dz = dx / length, dy / length, dz / length

    # where the ray is inside the grid, t_in <= t <= t_out, by slabs
    t_in, t_out = 0.0, length
    d = (dx, dy, dz)
    n = (nx, ny, nz)
    for axis in range(3):
        to_low = low[axis] - source[axis]
        to_high = to_low + n[axis] * spacing[axis]
        if d[axis] == 0.0:
            if to_low > 0.0 or to_high <= 0.0:
                t_out = -1.0
        else:
            t0, t1 = to_low / d[axis], to_high / d[axis]
            t_in = max(t_in, min(t0, t1))
            t_out = min(t_out, max(t0, t1))
    if t_in >= t_out:
        lengths[0] += length
        return
    lengths[0] += length - (t_out - t_in)

    # first voxel (i, j, k), and t of the next face and between faces along each axis
    x = (source[0] + t_in * dx - low[0]) / spacing[0]
    y = (source[1] + t_in * dy - low[1]) / spacing[1]
    z = (source[2] + t_in * dz - low[2]) / spacing[2]
    i = min(max(math.floor(x), 0), nx - 1)
    j = min(max(math.floor(y), 0), ny - 1)
    k = min(max(math.floor(z), 0), nz - 1)
    step_i, step_j, step_k = (1 if dx > 0 else -1), (1 if dy > 0 else -1), (1 if dz > 0 else -1)
    far = 2.0 * length
    tx = (low[0] + (i + (dx > 0)) * spacing[0] - source[0]) / dx if dx != 0.0 else far
    ty = (low[1] + (j + (dy > 0)) * spacing[1] - source[1]) / dy if dy != 0.0 else far
    tz = (low[2] + (k + (dz > 0)) * spacing[2] - source[2]) / dz if dz != 0.0 else far
    step_tx = spacing[0] / abs(dx) if dx != 0.0 else far
    step_ty = spacing[1] / abs(dy) if dy != 0.0 else far
    step_tz = spacing[2] / abs(dz) if dz != 0.0 else far

    t = t_in
    while True:
        here = index[k, j, i]
        t_next = min(tx, ty, tz)
        if t_next >= t_out:
            lengths[here] += t_out - t
            return
        lengths[here] += max(t_next - t, 0.0)
        t = max(t, t_next)
        if tx == t_next:
            tx += step_tx
            i += step_i
            if i < 0 or i >= nx:
                lengths[0] += t_out - t
                return
        elif ty == t_next:
            ty += step_ty
            j += step_j
            if j < 0 or j >= ny:
                lengths[0] += t_out - t
                return
        else:
            tz += step_tz
            k += step_k
            if k < 0 or k >= nz:
                lengths[0] += t_out - t
                return


@njit(cache=True, parallel=True)
def lengths_to(
    index: np.ndarray,
    low: np.ndarray,
    spacing: np.ndarray,
    source: np.ndarray,
    targets: np.ndarray,
    n_material: int,
) -> np.ndarray:
    """Lengths (n_target, n_material) mm of the segments from source (3,) to targets (n_target, 3)."""
    lengths = np.zeros((len(targets), n_material))
    for r in prange(len(targets)):
        material_lengths(index, low, spacing, source, targets[r], lengths[r])
    return lengths


@njit(cache=True, parallel=True)
def transmitted(
    index: np.ndarray,
    low: np.ndarray,
    spacing: np.ndarray,
    source: np.ndarray,
    corner: np.ndarray,
    step_u: np.ndarray,
    step_v: np.ndarray,
    shape: tuple[int, int],
    samples: int,
    mu: np.ndarray,
    weights: np.ndarray,
) -> np.ndarray:
    """Images (n_weight, nv, nu): sum_E weights exp(-sum_m mu L_m) cos(theta)/r^2, mean of samples^2 rays.

    corner (3,) of the detector; step_u, step_v (3,) one pixel along each axis;
    mu (n_material, n_energy) 1/mm; weights (n_weight, n_energy).
    """
    nv, nu = shape
    n_material, n_energy = mu.shape
    normal = np.cross(step_u, step_v)
    normal /= math.sqrt(np.sum(normal * normal))
    images = np.zeros((len(weights), nv, nu))
    for row in prange(nv):
        lengths = np.zeros(n_material)
        target = np.zeros(3)
        for column in range(nu):
            for a in range(samples * samples):
                u, v = column + (a % samples + 0.5) / samples, row + (a // samples + 0.5) / samples
                r2, height = 0.0, 0.0
                for axis in range(3):
                    target[axis] = corner[axis] + u * step_u[axis] + v * step_v[axis]
                    r = source[axis] - target[axis]
                    r2 += r * r
                    height += r * normal[axis]
                lengths[:] = 0.0
                material_lengths(index, low, spacing, source, target, lengths)
                share = height / (r2 * math.sqrt(r2) * samples * samples)
                for e in range(n_energy):
                    depth = 0.0
                    for m in range(n_material):
                        depth += mu[m, e] * lengths[m]
                    passed = share * math.exp(-depth)
                    for w in range(len(weights)):
                        images[w, row, column] += weights[w, e] * passed
    return images
