"""Blocks of histories, in rounds, until what is requested is known well enough.

Each block has its own random stream, and blocks are added in their order, so that any number of threads gives
the same tallies. Standard errors come from the scatter of the blocks: s/sqrt(n).
"""

import logging
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numba
import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.tally_result import Estimate, Sums

log = logging.getLogger(__name__)
FEWEST_BLOCKS = 32  # below, the standard error itself is uncertain by more than 1/sqrt(2 * 31) = 13 percent
HOPELESS = 2.0  # give up at once when this many times the allowed histories or seconds would be needed
MOST_VALUES = 4_000_000  # of tallies in memory at a time, beside their sums
Kernel = Callable[..., None]


@dataclass(frozen=True)
class Limits:
    """What a run may cost; beyond it is out of budget: histories, and seconds by the clock.

    Raises XrayError when they do not allow the fewest blocks.
    """

    histories: int = 2_000_000_000
    seconds: float = float("inf")

    def __post_init__(self) -> None:
        if self.histories < 1 or not self.seconds > 0:
            raise XrayError(f"limits of {self.histories} histories and {self.seconds} s must be positive")


@dataclass(frozen=True)
class Goal:
    """What is requested: `error` of the estimates, a number, at most `relative_error`; `what` names it."""

    what: str
    error: Callable[[list[Estimate]], float]
    relative_error: float


@dataclass(frozen=True)
class Run:
    """Estimates of the tallies per history, in the order of their shapes, and what they took."""

    estimates: list[Estimate]
    histories: int


def run_blocks(
    kernel: Kernel, shapes: tuple[tuple[int, ...], ...], goal: Goal, *, block: int, limits: Limits
) -> Run:
    """Calls kernel(b, *tallies), which adds the `block` histories of block b, until the goal is met.

    Raises XrayError when the limits do not suffice.
    """
    if limits.histories < FEWEST_BLOCKS * block:
        raise XrayError(
            f"{limits.histories} histories are fewer than {FEWEST_BLOCKS} blocks of {block}; allow more"
        )
    started = time.monotonic()
    sums, reached = Sums(), np.inf
    while True:
        for rows in _rounds(_next_blocks(sums.blocks, reached, goal, limits.histories // block), shapes):
            _in_threads(kernel, sums.blocks, rows)
            n = len(rows[0])
            sums.add(np.concatenate([row.reshape(n, -1) for row in rows], axis=1) / block)
        estimates = split(sums.estimate(), shapes)
        reached = goal.error(estimates)
        done, spent = sums.blocks * block, time.monotonic() - started
        log.info("%s: known to %.2g %% after %d histories", goal.what, 100 * reached, done)
        if reached <= goal.relative_error:
            return Run(estimates, done)
        require_hope(goal, reached, (done, spent), limits)


def relative(value: np.ndarray, error: np.ndarray) -> float:
    """Largest standard error of the values, of themselves; infinite where nothing has been seen yet."""
    seen = (value > 0) & (error > 0)
    return float((error / np.where(seen, value, 1)).max()) if seen.all() else np.inf


def require_hope(goal: Goal, reached: float, so_far: tuple[int, float], limits: Limits) -> None:
    """Raises XrayError when the limits are used up, or will clearly not do: error falls as 1/sqrt(n)."""
    done, spent = so_far
    more = (reached / goal.relative_error) ** 2 if np.isfinite(reached) else 2.0
    over = done >= limits.histories or spent >= limits.seconds
    if over or more * done > HOPELESS * limits.histories or more * spent > HOPELESS * limits.seconds:
        raise XrayError(
            f"{goal.what} is known to {reached:.2g} after {done} histories in {spent:.3g} s; "
            f"relative_error = {goal.relative_error:g} needs about {more * done:.2g} histories and "
            f"{more * spent:.2g} s, but {limits.histories} and {limits.seconds:g} s are allowed; "
            "raise it, or accept a larger error"
        )


def _next_blocks(done: int, reached: float, goal: Goal, most: int) -> int:
    """Blocks of the next round: what is needed by error ~ 1/sqrt(n), at most as many as were done."""
    if done == 0:
        return FEWEST_BLOCKS
    needed = done * (reached / goal.relative_error) ** 2 if np.isfinite(reached) else 2 * done
    return int(min(max(needed - done + 1, FEWEST_BLOCKS // 2), done, most - done))


def _rounds(n: int, shapes: tuple[tuple[int, ...], ...]) -> Iterator[list[np.ndarray]]:
    """Empty tallies of n blocks, so many at a time as memory allows."""
    width = sum(int(np.prod(shape)) for shape in shapes)
    step = max(MOST_VALUES // max(width, 1), 1)
    for first in range(0, n, step):
        yield [np.zeros((min(step, n - first), *shape)) for shape in shapes]


def _in_threads(kernel: Kernel, first: int, rows: list[np.ndarray]) -> None:
    def one(b: int) -> None:
        kernel(first + b, *(row[b] for row in rows))

    with ThreadPoolExecutor(numba.get_num_threads()) as pool:
        list(pool.map(one, range(len(rows[0]))))


def split(total: Estimate, shapes: tuple[tuple[int, ...], ...]) -> list[Estimate]:
    """The parts of one long estimate."""
    cuts = np.cumsum([int(np.prod(shape)) for shape in shapes])[:-1]
    return [
        Estimate(value.reshape(shape), error.reshape(shape))
        for value, error, shape in zip(np.split(total.value, cuts), np.split(total.error, cuts), shapes)
    ]
