"""One photon from the source to its end by plain transport: tallies by material, region, cell; compiled."""

import math

import numpy as np

from mammosim.io.compiled import njit
from mammosim.xray.interactions import LOWEST_KEV, Matter, between, coherent, incoherent, place, turned
from mammosim.xray.random_stream import compiled, random_stream
from mammosim.xray.source_sampling import Field, Triple, sampled_direction, sampled_line, to_detector
from mammosim.xray.transport_step import LOST, MET, SEEN, Body, transport_step


@compiled
def deposit(
    regions: np.ndarray, material: int, energy: float, x: float, y: float, z: float, by_material: np.ndarray,
    by_region: np.ndarray,
) -> None:  # fmt: skip
    """Adds the energy given at a point to its material and to the regions that hold it."""
    by_material[material] += energy
    for i in range(len(regions)):
        inside_x = regions[i, 0] <= x < regions[i, 3]
        inside_y = regions[i, 1] <= y < regions[i, 4]
        if inside_x and inside_y and regions[i, 2] <= z < regions[i, 5]:
            by_region[i] += energy


@compiled
def collided(
    matter: Matter, E: float, row: int, share: float, material: int, v: float, state: np.ndarray
) -> tuple[float, float]:
    """Energy left [keV], 0 when absorbed, and cos(theta), of a collision chosen by v in [0, mu)."""
    absorbed = between(matter.mu, row, share, material, 1)
    if v < absorbed:
        return 0.0, 1.0
    if v < absorbed + between(matter.mu, row, share, material, 2):
        E_new, cos = incoherent(E, material, matter.S, matter.x_step, state)
        return (E_new, cos) if E_new > LOWEST_KEV else (0.0, 1.0)
    return E, coherent(E, material, matter.area, matter.x_step, state)


@compiled
def after_collision(
    matter: Matter, field: Field, E: float, row: int, share: float, material: int, v: float, x: float,
    y: float, z: float, dx: float, dy: float, dz: float, state: np.ndarray,
) -> tuple[float, int, float, float, float, float, float, float, float]:  # fmt: skip
    """Of a photon that collides at (x, y, z): its energy, 0 when absorbed, with its row and share in the
    tables; its direction; how far, and where along u and v, it would be seen."""
    E_new, cos = collided(matter, E, row, share, material, v, state)
    if E_new == 0:
        return 0.0, row, share, dx, dy, dz, math.inf, 0.0, 0.0
    if E_new < E:
        row, share = place(E_new)
    dx, dy, dz = turned(dx, dy, dz, cos, state)
    t_seen, s, r = to_detector(field, x, y, z, dx, dy, dz)
    return E_new, row, share, dx, dy, dz, t_seen, s, r


@compiled
def track(
    body: Body, matter: Matter, field: Field, regions: np.ndarray, state: np.ndarray, by_material: np.ndarray,
    by_region: np.ndarray, cells: np.ndarray, balance: np.ndarray,
) -> None:  # fmt: skip
    """Follows one photon to its end.

    cells (3, nv, nu): primary keV, scatter keV, scatter keV2; balance (2,): keV emitted and escaped.
    """
    E = field.energies[sampled_line(field, state)]
    dx, dy, dz, t_seen, s, r = sampled_direction(field, state)
    x, y, z = field.source[0], field.source[1], field.source[2]
    row, share = place(E)
    balance[0] += E
    scattered = False
    while True:
        t, end, material, v = transport_step(body, matter, row, share, t_seen, x, y, z, dx, dy, dz, state)
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
        before = E
        E, row, share, dx, dy, dz, t_seen, s, r = after_collision(
            matter, field, E, row, share, material, v, x, y, z, dx, dy, dz, state
        )
        given = before - E
        if given > 0:
            deposit(regions, material, given, x, y, z, by_material, by_region)
            if E == 0:
                return
        scattered = True


@njit(cache=True, nogil=True)
def track_block(
    body: Body, matter: Matter, field: Field, regions: np.ndarray, block: int, histories: int, seed: int,
    by_material: np.ndarray, by_region: np.ndarray, cells: np.ndarray, balance: np.ndarray,
) -> None:  # fmt: skip
    """Adds the photons of one block, whose numbers depend on seed and block only, to its tallies, in keV.

    regions (n_region, 6) mm: boxes whose energy is tallied, too; by_material (n_material,),
    by_region (n_region,), cells (3, nv, nu), balance (2,).
    """
    state = random_stream(seed, block)
    for _ in range(histories):
        track(body, matter, field, regions, state, by_material, by_region, cells, balance)


@compiled
def give(cells: np.ndarray, per_mm: Triple, px: float, py: float, pz: float, energy: float) -> None:
    """Adds energy to the cell at a place (mm from low) of cells (nz, ny, nx); nothing outside of them."""
    nz, ny, nx = cells.shape
    i, j, k = int(np.floor(px * per_mm[0])), int(np.floor(py * per_mm[1])), int(np.floor(pz * per_mm[2]))
    if 0 <= i < nx and 0 <= j < ny and 0 <= k < nz:
        cells[k, j, i] += energy


@compiled
def track_mapped(
    body: Body, matter: Matter, field: Field, per_mm: Triple, state: np.ndarray, cells: np.ndarray
) -> None:
    """Follows one photon to its end."""
    E = field.energies[sampled_line(field, state)]
    dx, dy, dz, t_seen, _, _ = sampled_direction(field, state)
    x, y, z = field.source
    row, share = place(E)
    while True:
        t, end, material, v = transport_step(body, matter, row, share, t_seen, x, y, z, dx, dy, dz, state)
        if end != MET:
            return
        x, y, z = x + t * dx, y + t * dy, z + t * dz
        before = E
        E, row, share, dx, dy, dz, t_seen, _, _ = after_collision(
            matter, field, E, row, share, material, v, x, y, z, dx, dy, dz, state
        )
        given = before - E
        if given > 0:
            give(cells, per_mm, x - body.low[0], y - body.low[1], z - body.low[2], given)
            if E == 0:
                return


@njit(cache=True, nogil=True)
def map_block(
    body: Body, matter: Matter, field: Field, per_mm: Triple, block: int, histories: int, seed: int,
    cells: np.ndarray,
) -> None:  # fmt: skip
    """Adds the photons of one block to cells (nz, ny, nx), in keV; per_mm: cells per mm in (x, y, z)."""
    state = random_stream(seed, block)
    for _ in range(histories):
        track_mapped(body, matter, field, per_mm, state, cells)
