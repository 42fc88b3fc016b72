"""One symbolic analysis for many solves: sweeps and fixed points move nodes and keep the connectivity."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace

import numpy as np

from mammosim.mechanics.budget import Spending
from mammosim.mechanics.effects import Effect
from mammosim.mechanics.newton import System
from mammosim.mechanics.potential import Potential

_kept: ContextVar[list[System] | None] = ContextVar("systems kept by shared_analysis", default=None)


@contextmanager
def shared_analysis() -> Iterator[None]:
    """Solves inside reuse pattern, scatter and symbolic factorisation where they can.

    That is, where an earlier one had the same arrays of cells and faces (as TetMesh.moved_to keeps them) and
    the same held nodes. The memory of the factors is given back at the end, by the outermost one.
    """
    if _kept.get() is not None:
        yield
        return
    systems: list[System] = []
    token = _kept.set(systems)
    try:
        yield
    finally:
        _kept.reset(token)
        for system in systems:
            system.solver.release()


@contextmanager
def system_of(potential: Potential, held: np.ndarray, multigrid_above: int | None = None) -> Iterator[System]:
    """The system of a potential, held (n_node, 3) bool; kept for the next inside shared_analysis."""
    systems = _kept.get()
    if systems is None:
        with System.of(potential, held, multigrid_above) as system:
            yield system
        return
    for system in systems:
        if _is_like(system, potential, held):
            yield replace(system, potential=potential, spending=Spending())
            return
    systems.append(System.of(potential, held, multigrid_above))
    yield systems[-1]


def _is_like(system: System, potential: Potential, held: np.ndarray) -> bool:
    """Whether a potential couples the nodes of the same arrays of elements, under the same held nodes."""
    before, now = _coupling(system.potential), _coupling(potential)
    same = [type(effect) for effect in before] == [type(effect) for effect in now] and all(
        a.connectivity is b.connectivity for a, b in zip(before, now)
    )
    return same and np.array_equal(system.held, held)


def _coupling(potential: Potential) -> list[Effect]:
    return [effect for effect in potential.effects + potential.loads if len(effect.connectivity)]
