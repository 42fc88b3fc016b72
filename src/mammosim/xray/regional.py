"""The energy given to small boxes: by primary photons along exact rays, by scattered ones sampled, compiled.

A primary photon of energy E gives a stretch a..b of its ray, in one material,
E f (exp(-tau_a) - exp(-tau_b)), f = (mu_photoelectric + mu_incoherent <1 - E'/E>)/mu:
what its first collision leaves there, on average.
"""

import math

import numpy as np

from mammosim.io.compiled import njit
from mammosim.xray.interactions import (
    ELECTRON_REST_KEV,
    HC_KEV_ANGSTROM,
    Matter,
    between,
    place,
)
from mammosim.xray.random_stream import compiled, random_stream, uniform
from mammosim.xray.source_sampling import Field, sampled_direction, sampled_line
from mammosim.xray.tracking import after_collision, deposit
from mammosim.xray.transport_step import MET, Body, crossing, inverse, transport_step
from mammosim.xray.traversal import MATERIAL, TAU, T, traversed

N_ANGLES = 2000
FAR = 6.0  # of so many photons that start towards far from the regions one is followed, with this weight


def kept_fraction(matter: Matter, energies: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """f (n_energy, n_material); mu (n_energy, n_material, 2) 1/mm: total, and of scattering only."""
    cos = (np.arange(N_ANGLES) + 0.5) / N_ANGLES * 2 - 1
    x_table = matter.x_step * np.arange(matter.S.shape[1])
    f = np.empty(mu.shape[:2])
    for i, E in enumerate(energies):
        k = 1 / (1 + E / ELECTRON_REST_KEV * (1 - cos))
        klein_nishina = k**2 * (k + 1 / k - (1 - cos**2))
        x = E / HC_KEV_ANGSTROM * np.sqrt((1 - cos) / 2)
        row, share = place(E)
        for m in range(mu.shape[1]):
            density = klein_nishina * np.interp(x, x_table, matter.S[m])
            lost = np.sum(density * (1 - k)) / np.sum(density)
            absorbed = mu[i, m, 0] - mu[i, m, 1]
            f[i, m] = (absorbed + between(matter.mu, row, share, m, 2) * lost) / mu[i, m, 0]
    return f


@compiled
def given_along(path: np.ndarray, n: int, f: np.ndarray, t_in: float, t_out: float) -> float:
    """What a primary photon of unit energy gives between two distances of its path."""
    given = 0.0
    for i in range(1, n + 1):
        a, b = max(path[i - 1, T], t_in), min(path[i, T], t_out)
        if a < b:
            mu = (path[i, TAU] - path[i - 1, TAU]) / (path[i, T] - path[i - 1, T])
            tau = path[i - 1, TAU] + mu * (a - path[i - 1, T])
            given += f[int(path[i, MATERIAL])] * math.exp(-tau) * (1 - math.exp(-mu * (b - a)))
    return given


@njit(cache=True, nogil=True)
def primary_given(
    body: Body, mu: np.ndarray, f: np.ndarray, field: Field, box: np.ndarray, window: np.ndarray, rays: int,
    steps: int, seed: int,
) -> np.ndarray:  # fmt: skip
    """What photons of unit energy give to a box, times h/r^3: (n_energy,), a mean over rays^2 places.

    mu (n_energy, n_material, 2) 1/mm; box (1, 6) mm; window (4,) mm: low and high along u, then v, of the
    part of the detector that holds the box's shadow.
    """
    state, path, given = random_stream(seed, 0), np.empty((steps, 4)), np.zeros(len(mu))
    c, q = field.corner, field.source
    for i in range(rays * rays):
        s = window[0] + (i // rays + uniform(state)) / rays * (window[1] - window[0])
        r = window[2] + (i % rays + uniform(state)) / rays * (window[3] - window[2])
        x = c[0] + s * field.u[0] + r * field.v[0] - q[0]
        y = c[1] + s * field.u[1] + r * field.v[1] - q[1]
        z = c[2] + s * field.u[2] + r * field.v[2] - q[2]
        length = math.sqrt(x * x + y * y + z * z)
        dx, dy, dz = x / length, y / length, z / length
        t_in, t_out = crossing(box, 0, q[0], q[1], q[2], inverse(dx), inverse(dy), inverse(dz))
        if t_in >= t_out:
            continue
        height = -(x * field.n[0] + y * field.n[1] + z * field.n[2])
        for e in range(len(mu)):
            n = traversed(body, mu[e], length, q, (dx, dy, dz), path)
            given[e] += given_along(path, n, f[e], t_in, t_out) * height / length**3
    return given / (rays * rays)


@compiled
def track_scattered(
    body: Body, matter: Matter, field: Field, regions: np.ndarray, near: np.ndarray, state: np.ndarray,
    by_material: np.ndarray, by_region: np.ndarray,
) -> None:  # fmt: skip
    """Follows one photon to its end, and tallies all but its first collision."""
    E, w = field.energies[sampled_line(field, state)], 1.0
    dx, dy, dz, t_seen, s, r = sampled_direction(field, state)
    if s < near[0] or s > near[1] or r < near[2] or r > near[3]:
        if uniform(state) * FAR >= 1:
            return
        w = FAR
    x, y, z = field.source
    row, share = place(E)
    primary = True
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
            if not primary:
                deposit(regions, material, w * given, x, y, z, by_material, by_region)
            if E == 0:
                return
        primary = False


@njit(cache=True, nogil=True)
def scattered_block(
    body: Body, matter: Matter, field: Field, regions: np.ndarray, near: np.ndarray, block: int,
    histories: int, seed: int, by_material: np.ndarray, by_region: np.ndarray,
) -> None:  # fmt: skip
    """Adds what scattered photons of one block give to materials (n_material,) and regions (n_region,).

    near (4,) mm: the part of the detector, low and high along u, then v, towards which all are followed.
    """
    state = random_stream(seed, block)
    for _ in range(histories):
        track_scattered(body, matter, field, regions, near, state, by_material, by_region)
