"""One photon from the source to its end, compiled.

Inside a box, Woodcock tracking: flights of length -ln(u)/M, with M the box's largest mu; a stop in material m
is real with probability mu_m/M. Outside all boxes there is nothing but air, in which one flight is exact.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from mammosim.xray.interactions import LOWEST_KEV, Matter, between, coherent, incoherent, place, turned
from mammosim.xray.stream import stream, uniform

# ASSUME: photons that fly half a metre through the air without meeting body or detector do not come back.
LOST_AFTER_MM = 500.0
NEAR_MM = 1e-7  # a face nearer than this has been reached
FLAT = 1e-12  # smallest direction cosine
MET, ENTERED, LEFT, SEEN, LOST = 0, 1, 2, 3, 4  # what ends a flight


class Body(NamedTuple):
    """Voxels and the boxes around them.

    voxels (nz, ny, nx) uint8 material; low (3,) mm and per_mm (3,) voxels per mm in (x, y, z);
    boxes (n_box, 6): low xyz, high xyz, mm; majorant (n_energy, n_box) 1/mm;
    regions (n_region, 6) mm: boxes whose energy is tallied, too.
    """

    voxels: np.ndarray
    low: np.ndarray
    per_mm: np.ndarray
    boxes: np.ndarray
    majorant: np.ndarray
    regions: np.ndarray


class Field(NamedTuple):
    """Where photons start and are seen.

    source (3,); the detector's corner (3,), unit vectors u, v, n (3,), size (2,) mm, cells per_mm;
    energies (n,) keV with an alias table (kept, alias); nearest: distance of source and detector, mm.
    """

    source: np.ndarray
    corner: np.ndarray
    u: np.ndarray
    v: np.ndarray
    n: np.ndarray
    size: np.ndarray
    per_mm: float
    energies: np.ndarray
    kept: np.ndarray
    alias: np.ndarray
    nearest: float


@njit(cache=True)
def emitted(field: Field, state: np.ndarray) -> tuple[float, float, float, float]:
    """Energy and direction of a photon, isotropic within the detector's rectangle.

    A point of the rectangle at distance r is drawn evenly and kept by (nearest/r)^3: d Omega = h dA/r^3.
    """
    a = uniform(state) * len(field.energies)
    line = int(a)
    if a - line >= field.kept[line]:
        line = field.alias[line]
    while True:
        s, t = uniform(state) * field.size[0], uniform(state) * field.size[1]
        dx = field.corner[0] + s * field.u[0] + t * field.v[0] - field.source[0]
        dy = field.corner[1] + s * field.u[1] + t * field.v[1] - field.source[1]
        dz = field.corner[2] + s * field.u[2] + t * field.v[2] - field.source[2]
        r = math.sqrt(dx * dx + dy * dy + dz * dz)
        if uniform(state) < (field.nearest / r) ** 3:
            return field.energies[line], dx / r, dy / r, dz / r


@njit(cache=True)
def slab(low: float, high: float, position: float, inverse: float) -> tuple[float, float]:
    """Distances to entry and exit of low..high along one axis, with 1/direction."""
    a, b = (low - position) * inverse, (high - position) * inverse
    return (a, b) if a < b else (b, a)


@njit(cache=True)
def crossing(
    boxes: np.ndarray, i: int, x: float, y: float, z: float, ix: float, iy: float, iz: float
) -> tuple[float, float]:
    """Distances at which the ray enters and leaves box i of (n_box, 6); missed when the first is larger."""
    x0, x1 = slab(boxes[i, 0], boxes[i, 3], x, ix)
    y0, y1 = slab(boxes[i, 1], boxes[i, 4], y, iy)
    z0, z1 = slab(boxes[i, 2], boxes[i, 5], z, iz)
    return max(x0, y0, z0), min(x1, y1, z1)


@njit(cache=True)
def inverse(d: float) -> float:
    """1/d, with directions in a plane taken as nearly so."""
    return 1 / d if abs(d) > FLAT else math.copysign(1 / FLAT, d)


@njit(cache=True)
def to_detector(
    field: Field, x: float, y: float, z: float, dx: float, dy: float, dz: float
) -> tuple[float, float, float]:
    """Distance to the detector, infinite when missed, and where along u and v from its corner."""
    sinking = -(dx * field.n[0] + dy * field.n[1] + dz * field.n[2])
    cx, cy, cz = x - field.corner[0], y - field.corner[1], z - field.corner[2]
    height = cx * field.n[0] + cy * field.n[1] + cz * field.n[2]
    if sinking <= FLAT or height < 0:
        return math.inf, 0.0, 0.0
    t = height / sinking
    cx, cy, cz = cx + t * dx, cy + t * dy, cz + t * dz
    s = cx * field.u[0] + cy * field.u[1] + cz * field.u[2]
    r = cx * field.v[0] + cy * field.v[1] + cz * field.v[2]
    if s < 0 or s >= field.size[0] or r < 0 or r >= field.size[1]:
        return math.inf, s, r
    return t, s, r


@njit(cache=True)
def deposit(
    body: Body, material: int, energy: float, x: float, y: float, z: float, by_material: np.ndarray,
    by_region: np.ndarray,
) -> None:  # fmt: skip
    """Adds the energy given at a point to its material and to the regions that hold it."""
    by_material[material] += energy
    for i in range(len(body.regions)):
        inside_x = body.regions[i, 0] <= x < body.regions[i, 3]
        inside_y = body.regions[i, 1] <= y < body.regions[i, 4]
        if inside_x and inside_y and body.regions[i, 2] <= z < body.regions[i, 5]:
            by_region[i] += energy


@njit(cache=True)
def fly_in_air(
    body: Body, mu: float, t_seen: float, x: float, y: float, z: float, dx: float, dy: float, dz: float,
    state: np.ndarray,
) -> tuple[float, int, int]:  # fmt: skip
    """A flight outside all boxes: its length, what ends it, and the box entered."""
    ix, iy, iz = inverse(dx), inverse(dy), inverse(dz)
    t_end, end, box = LOST_AFTER_MM, LOST, -1
    for i in range(len(body.boxes)):
        t_in, t_out = crossing(body.boxes, i, x, y, z, ix, iy, iz)
        if t_in < t_out and t_out > NEAR_MM and (box < 0 or t_in < t_end):
            t_end, end, box = max(t_in, 0.0), ENTERED, i
    if t_seen <= t_end or (box < 0 and t_seen < math.inf):
        t_end, end = t_seen, SEEN
    t = -math.log(1 - uniform(state)) / mu
    return (t, MET, -1) if t < t_end else (t_end, end, box)


@njit(cache=True)
def fly_in_box(
    body: Body, matter: Matter, row: int, share: float, box: int, t_seen: float, x: float, y: float, z: float,
    dx: float, dy: float, dz: float, state: np.ndarray,
) -> tuple[float, int, int, float]:  # fmt: skip
    """A flight inside a box: its length, what ends it, the material met and a number even in [0, its mu)."""
    _, t_out = crossing(body.boxes, box, x, y, z, inverse(dx), inverse(dy), inverse(dz))
    t_end, end = (t_seen, SEEN) if t_seen < t_out else (max(t_out, 0.0), LEFT)
    M = between(body.majorant, row, share, box)
    nz, ny, nx = body.voxels.shape
    x, y, z = x - body.low[0], y - body.low[1], z - body.low[2]
    t = 0.0
    while True:
        t -= math.log(1 - uniform(state)) / M
        if t >= t_end:
            return t_end, end, 0, 0.0
        i = min(max(int((x + t * dx) * body.per_mm[0]), 0), nx - 1)
        j = min(max(int((y + t * dy) * body.per_mm[1]), 0), ny - 1)
        k = min(max(int((z + t * dz) * body.per_mm[2]), 0), nz - 1)
        material = body.voxels[k, j, i]
        v = M * uniform(state)
        if v < between(matter.total, row, share, material):
            return t, MET, material, v


@njit(cache=True)
def track(
    body: Body, matter: Matter, field: Field, state: np.ndarray, by_material: np.ndarray,
    by_region: np.ndarray, cells: np.ndarray, balance: np.ndarray,
) -> None:  # fmt: skip
    """Follows one photon to its end.

    cells (3, nv, nu): primary keV, scatter keV, scatter keV2; balance (2,): keV emitted and escaped.
    """
    E, dx, dy, dz = emitted(field, state)
    x, y, z = field.source[0], field.source[1], field.source[2]
    row, share = place(E)
    balance[0] += E
    box, scattered = -1, False
    while True:
        t_seen, s, r = to_detector(field, x, y, z, dx, dy, dz)
        if box < 0:
            mu, material = between(matter.total, row, share, 0), 0
            t, end, box = fly_in_air(body, mu, t_seen, x, y, z, dx, dy, dz, state)
            v = mu * uniform(state) if end == MET else 0.0
        else:
            t, end, material, v = fly_in_box(
                body, matter, row, share, box, t_seen, x, y, z, dx, dy, dz, state
            )
            if end == LEFT:
                box = -1
        if end == LOST:
            balance[1] += E
            return
        if end == SEEN:
            i, j = int(r * field.per_mm), int(s * field.per_mm)
            if scattered:
                cells[1, i, j] += E
                cells[2, i, j] += E * E
            else:
                cells[0, i, j] += E
            return
        x, y, z = x + t * dx, y + t * dy, z + t * dz
        if end != MET:
            continue

        absorbed = between(matter.absorbed, row, share, material)
        if v < absorbed:
            deposit(body, material, E, x, y, z, by_material, by_region)
            return
        scattered = True
        if v < absorbed + between(matter.incoherent, row, share, material):
            E_new, cos = incoherent(E, material, matter.S, matter.x_step, state)
            if E_new <= LOWEST_KEV:
                E_new = 0.0
            deposit(body, material, E - E_new, x, y, z, by_material, by_region)
            if E_new == 0:
                return
            E = E_new
            row, share = place(E)
        else:
            cos = coherent(E, material, matter.area, matter.x_step, state)
        dx, dy, dz = turned(dx, dy, dz, cos, state)


@njit(cache=True, parallel=True)
def track_blocks(
    body: Body, matter: Matter, field: Field, first: int, histories: int, seed: int, by_material: np.ndarray,
    by_region: np.ndarray, cells: np.ndarray, balance: np.ndarray,
) -> None:  # fmt: skip
    """Fills one row of each tally per block, whose numbers depend on seed and block only.

    by_material (n_block, n_material), by_region (n_block, n_region), cells (n_block, 3, nv, nu),
    balance (n_block, 2), in keV.
    """
    for b in prange(len(balance)):
        state = stream(seed, first + b)
        for _ in range(histories):
            track(body, matter, field, state, by_material[b], by_region[b], cells[b], balance[b])
