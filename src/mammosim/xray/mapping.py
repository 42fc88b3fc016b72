"""Where in the body the energy is given: a map in cells, compiled."""

import numpy as np

from mammosim.io.compiled import njit
from mammosim.xray.interactions import Matter, place
from mammosim.xray.random_stream import compiled, random_stream
from mammosim.xray.source_sampling import Field, Triple, sampled_direction, sampled_line
from mammosim.xray.tracking import after_collision
from mammosim.xray.transport_step import MET, Body, transport_step


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
