"""The scatter that reaches the detector, with little variance, compiled.

The ray of every scattered photon is traversed to its end: w E exp(-tau) would arrive without another
collision, and is scored. Then the photon is made to scatter on that ray, at a place drawn from p(s), s the
depth of scattering so far, so that its weight becomes w exp(-tau(s))/p(s). In a slab the depths before and
after a collision add up to the same on the straight way down, where p is even; sideways p falls with the
attenuation. Photons that promise less than the others play Russian roulette before their ray is traversed.
The first ray, which costs most, serves several first collisions.
"""

import math
from typing import NamedTuple

import numpy as np

from mammosim.io.compiled import njit
from mammosim.xray.interactions import LOWEST_KEV, Matter, between, coherent, incoherent, place, turned
from mammosim.xray.random_stream import compiled, random_stream, uniform
from mammosim.xray.source_sampling import Field, Triple, sampled_direction, sampled_line, to_detector
from mammosim.xray.transport_step import Body
from mammosim.xray.traversal import SCATTERS, TAU, ends, scattering_point, traversed

# These change the variance, never the mean; chosen as measured in docs/decisions/xray_transport.md.
FIRST_COLLISIONS = 6
UPWARD = 0.1  # what moving away from the detector promises, in units of a straight way down
AGAIN = 0.3  # and what further collisions do, on a ray towards it
ELSEWHERE = 0.1  # and what reaching a cell does that was not requested
BESIDE = (
    3  # of so many first rays towards cells not requested one is taken, with so many times the collisions
)


class Setting(NamedTuple):
    """What photons cross, from where to where, and what is requested.

    weights (n_energy,) undo a bias of the energies; requested (nv, nu) bool: the cells that matter.
    """

    body: Body
    matter: Matter
    field: Field
    weights: np.ndarray
    requested: np.ndarray


class Scratch(NamedTuple):
    """Room for mu (n_material, 2), total and of scattering, 1/mm, and for a path (n + 1, 4)."""

    mu: np.ndarray
    path: np.ndarray


class Photon(NamedTuple):
    """Energy [keV], weight, place [mm] and direction."""

    energy: float
    weight: float
    at: Triple
    along: Triple


class Promise(NamedTuple):
    """By which photons are judged: `fair` contributes enough to be followed; optical depth grows by `slope`
    per mm of height above `bottom`, the height of the body's lower end, mm, up to that of the whole body:
    above it there is air, from where a photon promises no less."""

    fair: float
    slope: float
    bottom: float
    whole: float


@compiled
def attenuation(matter: Matter, energy: float, mu: np.ndarray) -> None:
    """Total attenuation and scattering, 1/mm, of each material at an energy: mu (n_material, 2)."""
    row, share = place(energy)
    for m in range(len(mu)):
        mu[m, 0] = between(matter.mu, row, share, m, 0)
        mu[m, 1] = mu[m, 0] - between(matter.mu, row, share, m, 1)


@compiled
def dot(a: Triple, b: Triple) -> float:
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def further(p: Photon, t: float, weight: float) -> Photon:
    """The photon after a distance t."""
    x, y, z = p.at
    dx, dy, dz = p.along
    return Photon(p.energy, weight, (x + t * dx, y + t * dy, z + t * dz), p.along)


@compiled
def scattered(p: Photon, material: int, scattering: float, matter: Matter, state: np.ndarray) -> Photon:
    """The photon after a collision in a material whose attenuation by scattering is given."""
    row, share = place(p.energy)
    E = p.energy
    if uniform(state) * scattering < between(matter.mu, row, share, material, 2):
        E, cos = incoherent(E, material, matter.S, matter.x_step, state)
    else:
        cos = coherent(E, material, matter.area, matter.x_step, state)
    return Photon(E, p.weight, p.at, turned(p.along[0], p.along[1], p.along[2], cos, state))


@compiled
def chance(p: Photon, promise: Promise, worth: float, field: Field) -> float:
    """What the photon promises, in units of what is fair; worth: of the cell on its ray."""
    down = -dot(p.along, field.n)
    height = dot(p.at, field.n) - dot(field.corner, field.n)
    tau = min(promise.slope * max(height - promise.bottom, 0.0), promise.whole)
    hope = (AGAIN if down > 0 else UPWARD) * math.exp(-tau)
    if worth > 0:
        hope += worth * math.exp(-tau / down)
    return p.weight * hope / promise.fair


@compiled
def follow(
    p: Photon, material: int, scattering: float, promise: Promise, setting: Setting, room: Scratch,
    state: np.ndarray, cells: np.ndarray,
) -> None:  # fmt: skip
    """Scores a photon that collides, from here to its end; cells (2, nv, nu) in keV and keV2."""
    field, mu, path = setting.field, room.mu, room.path
    while True:
        p = scattered(p, material, scattering, setting.matter, state)
        if p.energy <= LOWEST_KEV:
            return
        t_seen, s, r = to_detector(field, p.at[0], p.at[1], p.at[2], p.along[0], p.along[1], p.along[2])
        i, j, worth = 0, 0, 0.0
        if t_seen < math.inf:
            i, j = int(r * field.per_mm), int(s * field.per_mm)
            worth = 1.0 if setting.requested[i, j] else ELSEWHERE
        survival = min(chance(p, promise, worth, field), 1.0)
        if uniform(state) >= survival:
            return
        attenuation(setting.matter, p.energy, mu)
        n = traversed(setting.body, mu, t_seen, p.at, p.along, path)
        w = p.weight / survival
        if t_seen < math.inf:
            score = w * p.energy * math.exp(-path[n, TAU])
            cells[0, i, j] += score
            cells[1, i, j] += score * p.energy
        kappa = 1 + dot(p.along, field.n)
        t, tau, material, per_density = scattering_point(path, n, uniform(state), kappa)
        scattering = mu[material, 1]
        p = further(p, t, w * per_density * math.exp(-tau))


@compiled
def history(setting: Setting, first: Scratch, room: Scratch, state: np.ndarray, cells: np.ndarray) -> None:
    """One photon from the source, and all that its first ray may become."""
    field, path = setting.field, first.path
    i = sampled_line(field, state)
    dx, dy, dz, t_seen, s, r = sampled_direction(field, state)
    collisions, weight = FIRST_COLLISIONS, setting.weights[i]
    if not setting.requested[int(r * field.per_mm), int(s * field.per_mm)]:
        if uniform(state) * BESIDE >= 1:
            return
        collisions, weight = collisions * BESIDE, weight * BESIDE
    p = Photon(field.energies[i], weight, field.source, (dx, dy, dz))
    attenuation(setting.matter, p.energy, first.mu)
    n = traversed(setting.body, first.mu, t_seen, p.at, p.along, path)
    tau, S = path[n, TAU], path[n, SCATTERS]
    top, bottom = ends(path, n)
    down = -dot(p.along, field.n)
    weight *= S / collisions
    slope = tau / max((bottom - top) * down, 1.0)
    promise = Promise(weight * math.exp(-tau), slope, (t_seen - bottom) * down, tau)
    for k in range(collisions):
        t, tau, material, _ = scattering_point(path, n, (k + uniform(state)) / collisions, 0.0)
        collides = further(p, t, weight * math.exp(-tau))
        follow(collides, material, first.mu[material, 1], promise, setting, room, state, cells)


@njit(cache=True, nogil=True)
def scatter_block(
    setting: Setting, steps: int, block: int, histories: int, seed: int, cells: np.ndarray
) -> None:
    """Adds the scatter of one block, whose numbers depend on seed and block only: cells (2, nv, nu).

    steps: of the longest path.
    """
    state = random_stream(seed, block)
    n_material = setting.matter.mu.shape[1]
    first = Scratch(np.empty((n_material, 2)), np.empty((steps, 4)))
    room = Scratch(np.empty((n_material, 2)), np.empty((steps, 4)))
    for _ in range(histories):
        history(setting, first, room, state, cells)
