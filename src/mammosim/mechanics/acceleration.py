"""Anderson's acceleration of a fixed point (Anderson 1965; Walker & Ni 2011)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mammosim.mechanics.fixed_point import Tried, damped


@dataclass(frozen=True)
class Anderson:
    """Steps that use the last `depth` guesses, each followed by damped ones should it be of no use.

    With dX, dU the differences (3 n_node, m) of successive guesses and of their corrections, the step is
    u - (dX + dU) gamma, where gamma minimises |u - dU gamma|.
    """

    depth: int = 5

    def __call__(self, past: Sequence[Tried], damping: float) -> Iterator[tuple[np.ndarray, float]]:
        """The accelerated step once there are two guesses, then damped ones."""
        recent = past[-self.depth - 1 :]
        if len(recent) > 1:
            yield accelerated(recent), 1.0
        yield from damped(past, damping)


def accelerated(recent: Sequence[Tried]) -> np.ndarray:
    """The step (n_node, 3) from the last of at least two guesses."""
    u = recent[-1].u
    dX = np.diff([tried.X.ravel() for tried in recent], axis=0).T
    dU = np.diff([tried.u.ravel() for tried in recent], axis=0).T
    gamma, *_ = np.linalg.lstsq(dU, u.ravel())
    step: np.ndarray = u - ((dX + dU) @ gamma).reshape(u.shape)
    return step
