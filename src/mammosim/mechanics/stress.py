"""The stress of cells, by the forces with which they act on their nodes.

v sigma = integral of P F^T dV = sum_a f_a (x) (x_a - c), since sum_a x_a (x) dN_a/dX = F: the mean Cauchy
stress of a loaded cell, whatever its law, with the same quadrature; the f_a of a cell add up to zero, so that
its middle c is free.
"""

from collections.abc import Iterable

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import Effect, MixedNeoHookean, NeoHookean


def bulk_of(effects: Iterable[Effect]) -> NeoHookean | MixedNeoHookean:
    """The bulk tissue among the effects. Raises MechanicsError where there is none."""
    for effect in effects:
        if isinstance(effect, NeoHookean | MixedNeoHookean):
            return effect
    raise MechanicsError("no bulk tissue among the effects; give those of mechanics.body.Body.effects")


def cauchy_stress(bulk: NeoHookean | MixedNeoHookean, x: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """sigma (n_cell, 3, 3) kPa of bulk tissue in the shape x (n_node, 3); volume (n_cell,): loaded, mm3.

    Of the bulk alone: skin, fascia and ligaments carry stress of their own.
    """
    nodes = x[bulk.cells]
    arm = nodes - nodes.mean(axis=1, keepdims=True)
    moment = np.einsum("eai,eaj->eij", bulk.cell_forces(x), arm)
    sigma: np.ndarray = (moment + np.swapaxes(moment, 1, 2)) / (2 * volume[:, None, None])
    return sigma


def von_mises(sigma: np.ndarray) -> np.ndarray:
    """sqrt(3/2 s : s) (n_cell,) kPa, s = sigma - tr(sigma) / 3."""
    s = sigma - np.trace(sigma, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    found: np.ndarray = np.sqrt(1.5 * np.einsum("eij,eij->e", s, s))
    return found
