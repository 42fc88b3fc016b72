"""Where photons start and where they are seen, compiled."""

import math
from typing import NamedTuple

import numpy as np

from mammosim.xray.random_stream import compiled, uniform

Triple = tuple[float, float, float]  # which compiled code reads faster than an array
FLAT = 1e-12  # smallest direction cosine


class Field(NamedTuple):
    """Where photons start and are seen.

    source (3,); the detector's corner (3,), unit vectors u, v, n (3,), size (2,) mm, cells per_mm;
    energies (n,) keV with an alias table (kept, alias); nearest: distance of source and detector, mm.
    """

    source: Triple
    corner: Triple
    u: Triple
    v: Triple
    n: Triple
    size: tuple[float, float]
    per_mm: float
    energies: np.ndarray
    kept: np.ndarray
    alias: np.ndarray
    nearest: float


@compiled
def sampled_line(field: Field, state: np.ndarray) -> int:
    """One of the spectrum's lines, by Walker's alias table."""
    a = uniform(state) * len(field.energies)
    i = int(a)
    return i if a - i < field.kept[i] else field.alias[i]


@compiled
def sampled_direction(field: Field, state: np.ndarray) -> tuple[float, float, float, float, float, float]:
    """Direction of a photon, isotropic within the detector's rectangle; how far, and where it would be seen.

    A point of the rectangle at distance r is drawn evenly and kept by (nearest/r)^3: d Omega = h dA/r^3.
    """
    while True:
        s, t = uniform(state) * field.size[0], uniform(state) * field.size[1]
        dx = field.corner[0] + s * field.u[0] + t * field.v[0] - field.source[0]
        dy = field.corner[1] + s * field.u[1] + t * field.v[1] - field.source[1]
        dz = field.corner[2] + s * field.u[2] + t * field.v[2] - field.source[2]
        r = math.sqrt(dx * dx + dy * dy + dz * dz)
        q = field.nearest / r
        if uniform(state) < q * q * q:
            return dx / r, dy / r, dz / r, r, s, t


@compiled
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
