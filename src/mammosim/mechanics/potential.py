"""The potential energy of a body, Pi = sum of effects + load factor * sum of loads."""

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
