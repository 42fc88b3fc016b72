"""What the solver knows of an effect: a term of the potential energy, its gradient and its tangent."""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from mammosim.mechanics.pattern import Tangent

NO_ELEMENTS = np.empty((0, 1), dtype=np.int64)


class Effect(Protocol):
    """One physical thing that a problem may include; it knows nothing of the others.

    x: (n_node, 3) loaded positions, mm. Energies in uJ, gradients in mN, tangents in mN/mm.
    """

    @property
    def connectivity(self) -> np.ndarray:
        """(n_element, m) nodes that the tangent couples; NO_ELEMENTS where it is zero."""

    def energy(self, x: np.ndarray) -> float:
        """The energy; infinite where the shape is impossible."""
        ...

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g += dE/dx, g (n_node, 3)."""
        ...

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K += d2E/dx2, or with `projected` its positive semidefinite part at each integration point."""
        ...

    def smallest_J(self, x: np.ndarray) -> float:
        """The smallest volume ratio of the integration points; infinite for an effect without volume."""
        ...

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> "Effect":
        """The effect whose tangent Newton should use at x + dx, after a step dx from x (see NeoHookean)."""
        ...


class WithoutVolume:
    """What effects that have no volume ratio and no prediction share."""

    def smallest_J(self, x: np.ndarray) -> float:
        """No volume, no limit."""
        return np.inf

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> Self:
        """Itself."""
        return self


@dataclass(frozen=True)
class Scaled(WithoutVolume):
    """factor times an effect: how loads are applied step by step."""

    effect: Effect
    factor: float

    @property
    def connectivity(self) -> np.ndarray:
        """That of the effect."""
        return self.effect.connectivity

    def energy(self, x: np.ndarray) -> float:
        """factor E."""
        return self.factor * self.effect.energy(x)

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g += factor dE/dx."""
        part = np.zeros_like(g)
        self.effect.add_gradient(x, part)
        g += self.factor * part

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K += factor d2E/dx2."""
        if len(self.connectivity):
            part = Tangent.zero(K.pattern)
            self.effect.add_tangent(x, part, projected=projected)
            part.blocks *= self.factor
            K.blocks += part.blocks
            part.give_back()
