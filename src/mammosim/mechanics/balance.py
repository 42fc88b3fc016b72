"""Energy balance: the work that the forces do on the way to a state, against the energy that it stores."""

import numpy as np

from mammosim.mechanics.potential import Potential

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_MOST_PARTS = 16
_ENOUGH = 1e-4


def energy_imbalance(potential: Potential, path: list[np.ndarray]) -> float:
    """|W - (E(x_n) - E(x_0))| relative to the largest |E(x_i) - E(x_0)|, of the effects without loads.

    path: shapes x_0 ... x_n (n_node, 3), joined by straight lines, W the sum of the integrals of dE/dx . dx
    along them. Each is cut into parts until they agree, as contact and wrinkling are not smooth. A gradient
    that is not that of the energy leaves an imbalance of its size; a line with J <= 0 somewhere an infinite
    one. Zero where nothing moved.
    """
    effects = Potential(potential.effects)
    E = [effects.energy(x) for x in path]
    scale = max(abs(energy - E[0]) for energy in E)
    if scale == 0:
        return 0.0
    short = sum(
        abs(_segment(effects, x0, x1, scale) - (E1 - E0)) for x0, x1, E0, E1 in zip(path, path[1:], E, E[1:])
    )
    return float(short / scale) if np.isfinite(short) else np.inf


def _segment(effects: Potential, x0: np.ndarray, x1: np.ndarray, scale: float) -> float:
    """The integral of dE/dx . dx along a straight line."""
    work, parts = _work(effects, x0, x1, 1), 1
    while parts < _MOST_PARTS:
        parts *= 2
        last, work = work, _work(effects, x0, x1, parts)
        if abs(work - last) <= _ENOUGH * scale or not np.isfinite(work):
            return work
    return work


def _work(effects: Potential, x0: np.ndarray, x1: np.ndarray, parts: int) -> float:
    u = (x1 - x0) / parts
    work = 0.0
    for part in range(parts):
        for point, weight in zip(_POINTS, _WEIGHTS):
            x = x0 + (part + (1 + point) / 2) * u
            if effects.smallest_J(x) <= 0:
                return np.inf
            work += weight / 2 * float(np.sum(effects.gradient(x) * u))
    return work
