"""The potential energy of a body, Pi = sum of effects + load factor * sum of loads, and its balance."""

from dataclasses import dataclass, replace

import numpy as np

from mammosim.mechanics.effects.protocol import Effect, Scaled
from mammosim.mechanics.pattern import Pattern, Tangent


@dataclass(frozen=True)
class Potential:
    """A sum of effects, of which `loads` are scaled by load_factor in [0, 1]."""

    effects: tuple[Effect, ...]
    loads: tuple[Effect, ...] = ()
    load_factor: float = 1.0

    @property
    def terms(self) -> tuple[Effect, ...]:
        """All effects, the loads scaled."""
        return self.effects + tuple(Scaled(load, self.load_factor) for load in self.loads)

    def at(self, load_factor: float) -> "Potential":
        """The same body under a part of its loads."""
        return replace(self, load_factor=load_factor)

    def energy(self, x: np.ndarray) -> float:
        """Pi(x), uJ."""
        return float(sum(term.energy(x) for term in self.terms))

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """dPi/dx (n_node, 3), mN."""
        g = np.zeros_like(x)
        for term in self.terms:
            term.add_gradient(x, g)
        return g

    def tangent(self, x: np.ndarray, pattern: Pattern, *, projected: bool = False) -> Tangent:
        """d2Pi/dx2, mN/mm."""
        K = Tangent.zero(pattern)
        for term in self.terms:
            term.add_tangent(x, K, projected=projected)
        return K

    def smallest_J(self, x: np.ndarray) -> float:
        """The smallest volume ratio of all effects' integration points."""
        return min(term.smallest_J(x) for term in self.terms)

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> "Potential":
        """The potential whose tangent Newton should use at x + dx, having stepped by dx from x."""
        return replace(self, effects=tuple(effect.predicted(x, dx) for effect in self.effects))

    def force_scale(self, x: np.ndarray, free: np.ndarray) -> float:
        """The largest norm of any term's forces on the free degrees of freedom, free (n_node, 3) bool, mN.

        Without loads what is held drives the body, so that the forces there count, too.
        """
        counted = free if self.loads else np.ones_like(free)
        norms = [0.0]
        for term in self.terms:
            g = np.zeros_like(x)
            term.add_gradient(x, g)
            norms.append(float(np.linalg.norm(g[counted])))
        return max(norms)


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
