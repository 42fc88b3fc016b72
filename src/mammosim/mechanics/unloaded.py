"""The stress-free shape of a body that was measured under gravity: what every method takes and gives back.

The methods, by name, stand in mechanics.unloading.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.body import Body


class UnloadingStep(NamedTuple):
    """One iteration: distance of the reloaded to the measured skin nodes, and what it took."""

    iteration: int
    mean_mm: float
    max_mm: float
    damping: float
    factorisations: int
    seconds: float


@dataclass(frozen=True)
class Unloaded:
    """points (n_node, 3) mm of the stress-free shape; history: one row per iteration."""

    points: np.ndarray
    history: tuple[UnloadingStep, ...] = ()


@dataclass(frozen=True)
class UnloadingSettings:
    """When an iteration ends.

    tolerance_mm: largest distance of a node between the reloaded and the measured shape; max_iterations;
    smallest_damping: of a correction, before the iteration fails.
    """

    tolerance_mm: float = 0.05
    max_iterations: int = 40
    smallest_damping: float = 1 / 16

    @property
    def load_tolerance(self) -> float:
        """Of the free forces relative to the weight, for each equilibrium on the way.

        It leaves about that part of the displacement, up to 50 mm: a hundredth of tolerance_mm.
        """
        return max(1e-2 * self.tolerance_mm / 50, 1e-8)


DEFAULT = UnloadingSettings()


class Method(Protocol):
    """A way from the measured to the stress-free shape."""

    def __call__(
        self,
        measured: TetMesh,
        body: Body,
        *,
        gravity: np.ndarray,
        start: np.ndarray | None = None,
        settings: UnloadingSettings = DEFAULT,
    ) -> Unloaded:
        """The shape X that gravity, a unit vector (3,), brings to measured.points.

        start (n_node, 3): first guess of X, default the measured shape. Nodes of `posterior` stay where they
        were measured. Raises MechanicsError where X was not found, with the reason and what helps.
        """
        ...
