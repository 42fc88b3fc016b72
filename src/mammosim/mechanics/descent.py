"""Down to a minimum of the energy where Newton's method does not get: over folds, and when contact slips.

(K + c D) dx = - g with D the diagonal stiffness of the start: c grows until the matrix is positive definite
and the energy falls as expected, and shrinks while it does (Levenberg 1944; More 1983).
"""

from dataclasses import dataclass, replace

import numpy as np

from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.multigrid import IndefiniteTangent
from mammosim.mechanics.newton import Iteration, StepFailed, System
from mammosim.mechanics.pattern import Tangent

_MOST = 80
# Shifts relative to D: the smallest that is not zero, and the largest.
_SMALLEST_SHIFT, _LARGEST_SHIFT = 1e-5, 1e6
_ACCURACY = 1e-3


@dataclass(frozen=True)
class _Shift(WithoutVolume):
    """stiffness (n_node,) mN/mm of each node, without force."""

    nodes: np.ndarray
    stiffness: np.ndarray

    @property
    def connectivity(self) -> np.ndarray:
        return self.nodes

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        K.add(self.nodes, self.stiffness[:, None, None, None, None] * np.eye(3))


def descend(system: System, x: np.ndarray, history: list[Iteration], *, enough: float) -> np.ndarray:
    """A shape (n_node, 3) near a minimum: definite tangent, relative residual at most `enough`.

    Extends the history; raises StepFailed, and BudgetSpent.
    """
    potential = system.potential
    nodes = np.arange(len(x))[:, None]
    K = potential.tangent(x, system.pattern, projected=True)
    D = np.abs(K.diagonal()).mean(axis=1)
    K.give_back()
    energy, shift = potential.energy(x), 0.0
    for _ in range(_MOST):
        system.spending.iterate(x)
        residual, smallest_J = system.relative_residual(x), potential.smallest_J(x)
        if residual <= enough and shift <= _SMALLEST_SHIFT:
            return x
        dx, slope, shift, negative = _direction(system, x, _Shift(nodes, D), shift)
        trial = x + dx
        gain = energy - potential.energy(trial) if potential.smallest_J(trial) > 0.1 * smallest_J else -np.inf
        accepted = gain >= -1e-4 * slope
        history.append(Iteration(1.0, residual, energy, smallest_J, negative, float(accepted)))
        if accepted:
            x, energy = trial, energy - gain
            if gain >= -0.35 * slope:
                shift = shift / 4 if shift > _SMALLEST_SHIFT else 0.0
        else:
            shift = max(8 * shift, 10 * _SMALLEST_SHIFT)
    raise StepFailed(f"{_MOST} steps downhill left a residual of {residual:.1e}", x)


def _direction(
    system: System, x: np.ndarray, unit: _Shift, shift: float
) -> tuple[np.ndarray, float, float, int]:
    """dx (n_node, 3), its slope g . dx, the shift that it took, and the negative pivots without it."""
    g = system.free_gradient(x)
    negative = 0
    while shift <= _LARGEST_SHIFT:
        K = system.potential.tangent(x, system.pattern)
        replace(unit, stiffness=shift * unit.stiffness).add_tangent(x, K)
        try:
            step = system.solver.solve(K, -g, _ACCURACY)
            return system.spread(step), float(g @ step), shift, negative
        except IndefiniteTangent as found:
            negative = max(negative, found.negative)
            shift = max(4 * shift, 10 * _SMALLEST_SHIFT)
        finally:
            K.give_back()
    raise StepFailed("no step leads downhill", x, indefinite=True)
