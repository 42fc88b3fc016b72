"""Rigid motions that nothing holds: with one of them, no equilibrium is the only one."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import CoulombFriction, Effect, RigidContact
from mammosim.mechanics.newton import System

# Stiffness against a rigid motion, relative to that of every node held apart, which counts as none.
_NONE = 1e-9


def require_held(
    system: System, effects: Iterable[Effect], points: np.ndarray, *, pressed_along: np.ndarray | None = None
) -> None:
    """Raise MechanicsError, which names them, where what is held and the effects leave rigid motions.

    points (n_node, 3): the reference; pressed_along (3,): where smooth plates will hold the body. What
    contact or friction among the effects will hold is not known before.
    """
    if any(isinstance(effect, RigidContact | CoulombFriction) for effect in effects):
        return
    free = free_motions(system, points, pressed_along=pressed_along)
    if len(free):
        motions = " or ".join(map(_words, _reduced(free)))
        raise MechanicsError(
            f"nothing holds the body against {motions}: hold more components of its nodes, or let sliding "
            "tissue hold it"
        )


def free_motions(
    system: System, points: np.ndarray, *, pressed_along: np.ndarray | None = None
) -> np.ndarray:
    """(m, 6): translation t and rotation w of motions u = t + w x (X - mean of X) that cost nothing.

    t in mm, w in 1 per radius of gyration. Effects hold as stiffly as in the reference, points (n_node, 3).
    """
    from_middle = points - points.mean(axis=0)
    gyration = np.sqrt(np.mean(np.sum(from_middle**2, axis=1)))
    e = np.eye(3)
    modes = np.array(
        [
            *(np.tile(axis, (len(points), 1)) for axis in e),
            *(np.cross(axis, from_middle) / gyration for axis in e),
        ]
    )
    at_held = modes[:, system.held]
    values, vectors = np.linalg.eigh(at_held @ at_held.T)
    left: np.ndarray = vectors.T[values <= _NONE * values.max()]
    if len(left) == 0:
        return left
    motions = np.tensordot(left, modes, axes=1).reshape(len(left), -1)
    K = system.potential.tangent(points, system.pattern)
    A, D = replace(K, constraint=None).to_csr(), np.abs(K.diagonal()).ravel()
    K.give_back()
    stiffness, apart = motions @ (A @ motions.T), np.trace(motions @ (D[:, None] * motions.T))
    if pressed_along is not None:
        along = motions.reshape(len(left), -1, 3) @ pressed_along
        stiffness = stiffness + np.mean(D) * along @ along.T
    values, vectors = np.linalg.eigh(stiffness)
    free: np.ndarray = vectors.T[values <= _NONE * apart] @ left
    return free


def _reduced(motions: np.ndarray) -> np.ndarray:
    """Motions (m, 6) that span the same: first those without turning, then turns, along axes if possible.

    The reduced row echelon form of (w, t).
    """
    rows, first = np.roll(motions, 3, axis=1), 0
    for column in range(6):
        if first == len(rows):
            break
        largest = first + int(np.argmax(np.abs(rows[first:, column])))
        if abs(rows[largest, column]) < 1e-6:
            continue
        rows[[first, largest]] = rows[[largest, first]]
        rows[first] /= rows[first, column]
        others = np.arange(len(rows)) != first
        rows[others] -= np.outer(rows[others, column], rows[first])
        first += 1
    return np.roll(rows, 3, axis=1)[::-1]


def _words(motion: np.ndarray) -> str:
    t, w = motion[:3], motion[3:]
    name, axis = ("turning about", w) if np.linalg.norm(w) > 1e-6 * np.linalg.norm(t) else ("moving along", t)
    axis = axis / np.linalg.norm(axis) * np.sign(axis[np.argmax(np.abs(axis))])
    return f"{name} ({', '.join(f'{value + 0.0:.2f}' for value in np.round(axis, 2))})"
