"""The iteration of all fixed points: load a guess, compare with the measured shape, correct the guess.

X is the guess of the stress-free shape, x(X) its equilibrium under gravity, d = x(X) - measured. What a fixed
point does about d is its Correction; how far it goes along is its Steps. Every equilibrium begins at the
last one, moved by the step, and ends where what is left is small beside the tolerance.
"""

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.analysis import system_of
from mammosim.mechanics.body import Body
from mammosim.mechanics.effects import NeoHookean
from mammosim.mechanics.loading import Settings
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.reference import cell_quadrature, smallest_jacobians
from mammosim.mechanics.unloaded import DEFAULT, Unloaded, UnloadingSettings, UnloadingStep

# ASSUME: in the fixed point, interior nodes follow the skin as in a homogeneous elastic body, nu = 0.3.
_CARRIER = Tissue(youngs_modulus_kpa=1.0, poisson_ratio=0.3, density_g_cm3=0.0)
_ACCURACY = 1e-10


def carried(mesh: TetMesh, displacement: np.ndarray, prescribed: np.ndarray) -> np.ndarray:
    """The displacement (n_node, 3) mm of least energy with the given one at `prescribed` (n_node,) nodes.

    Raises MechanicsError when nothing is prescribed.
    """
    if not prescribed.any():
        raise MechanicsError("no node has a prescribed displacement; give the skin's or the posterior nodes")
    bulk = NeoHookean.of(mesh, dict.fromkeys(Label, _CARRIER))
    held = np.repeat(prescribed[:, None], 3, axis=1)
    u = np.where(held, displacement, 0.0)
    with system_of(Potential((bulk,)), held) as system:
        K = system.potential.tangent(mesh.points, system.pattern)
        force = -(K.to_csr() @ u.ravel())[system.rows.free]
        least: np.ndarray = u + system.spread(system.solver.solve(K, force, _ACCURACY))
        return least


log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Guess:
    """A stress-free shape X (mesh.points), its loaded shape x, and d = x - measured, (n_node, 3) each."""

    mesh: TetMesh
    x: np.ndarray
    d: np.ndarray
    factorisations: int


class Correction(Protocol):
    """What a fixed point does about d."""

    def driven(self, measured: TetMesh) -> np.ndarray:
        """(n,) numbers of the nodes whose d it makes vanish."""
        ...

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm: the whole correction of X, zero at the nodes of `posterior`."""
        ...


class Tried(NamedTuple):
    """A guess that was accepted: X (n_node, 3) and its whole correction u (n_node, 3)."""

    X: np.ndarray
    u: np.ndarray


# Steps(guesses so far, the current one last; damping): steps (n_node, 3) to try, each with its damping.
Steps = Callable[[Sequence[Tried], float], Iterator[tuple[np.ndarray, float]]]


def damped(past: Sequence[Tried], damping: float) -> Iterator[tuple[np.ndarray, float]]:
    """damping u, and its halves for as long as they are asked for."""
    while True:
        yield damping * past[-1].u, damping
        damping /= 2


@dataclass(frozen=True)
class FixedPoint:
    """A fixed point of a measured shape: what is measured, what carries it, and how it is corrected."""

    measured: TetMesh
    body: Body
    gravity: np.ndarray
    correction: Correction
    steps: Steps = damped
    settings: UnloadingSettings = DEFAULT

    def from_start(self, start: np.ndarray | None) -> Unloaded:
        """Iterate from a first guess (n_node, 3), default the measured shape.

        Raises MechanicsError when no step makes the distance fall, or not below the tolerance in time.
        """
        began = time.perf_counter()
        X = self.measured.points if start is None else held_as_measured(start, self.measured)
        guess, damping = self._first(X), 1.0
        past, history = [self._tried(guess)], [self._row(0, guess, 1.0, began)]
        while self.largest(guess) > self.settings.tolerance_mm:
            if len(history) > self.settings.max_iterations:
                raise MechanicsError(
                    f"{self.settings.max_iterations} fixed-point iterations left a distance of "
                    f"{self.largest(guess):.3f} mm (asked {self.settings.tolerance_mm:g} mm); allow more "
                    "iterations or a larger tolerance_mm, or take the inverse method"
                )
            began = time.perf_counter()
            guess, damping = self._next(guess, past, damping)
            past.append(self._tried(guess))
            history.append(self._row(len(history), guess, damping, began))
            damping = min(1.0, 2 * damping)
        return Unloaded(guess.mesh.points, tuple(history))

    def mean(self, guess: Guess) -> float:
        """Mean distance of the driven nodes, mm: what has to fall."""
        return float(self._distances(guess).mean())

    def largest(self, guess: Guess) -> float:
        """Largest distance of a driven node, mm."""
        return float(self._distances(guess).max())

    def _distances(self, guess: Guess) -> np.ndarray:
        distances: np.ndarray = np.linalg.norm(guess.d[self.correction.driven(self.measured)], axis=1)
        return distances

    def _first(self, X: np.ndarray) -> Guess:
        try:
            return self._loaded(X, None)
        except EquilibriumError as error:
            raise MechanicsError(
                f"the first guess has no equilibrium under gravity ({error}); give a start that is nearer to "
                "the stress-free shape, such as the mean of prone and supine, or take the inverse method"
            ) from error

    def _loaded(self, X: np.ndarray, x: np.ndarray | None) -> Guess:
        """The guess X, loaded from the neighbouring shape x, or from rest."""
        mesh = self.measured.moved_to(X)
        solver = Settings(newton=NewtonSettings(tolerance=self.settings.load_tolerance))
        state = self.body.load(mesh, np.asarray(self.gravity), start=x, settings=solver)
        return Guess(mesh, state.points, state.points - self.measured.points, state.factorisations)

    def _tried(self, guess: Guess) -> Tried:
        return Tried(guess.mesh.points, self.correction(guess))

    def _next(self, guess: Guess, past: Sequence[Tried], damping: float) -> tuple[Guess, float]:
        """The first of the steps that makes the mean distance fall, and its damping."""
        reason, before = "", self.mean(guess)
        for step, part in self.steps(past, damping):
            if part < self.settings.smallest_damping:
                break
            found = self._attempt(guess, step)
            if isinstance(found, Guess) and self.mean(found) < before:
                return found, part
            reason = found if isinstance(found, str) else f"the distance rose to {self.mean(found):.3f} mm"
        raise MechanicsError(
            f"the fixed point diverges at a mean of {before:.3f} mm: {reason}, even when damped to "
            f"{self.settings.smallest_damping:g}; the tissue may be too soft for the measured shape: raise "
            "its modulus, add skin, or take the inverse method"
        )

    def _attempt(self, guess: Guess, step: np.ndarray) -> Guess | str:
        """The guess after a step, or why there is none."""
        X = guess.mesh.points + step
        if smallest_jacobians(X, self.measured.cells).min() <= 0:
            return "the correction inverts cells"
        try:
            return self._loaded(X, guess.x + step)
        except EquilibriumError as error:
            return f"the corrected shape has no equilibrium ({error})"

    def _row(self, iteration: int, guess: Guess, damping: float, began: float) -> UnloadingStep:
        d = np.linalg.norm(guess.d[self.measured.boundary_nodes("skin")], axis=1)
        log.info("fixed point %d: mean %.3f mm, max %.3f mm", iteration, d.mean(), d.max())
        seconds = time.perf_counter() - began
        return UnloadingStep(
            iteration, float(d.mean()), float(d.max()), damping, guess.factorisations, seconds
        )


def held_as_measured(start: np.ndarray, measured: TetMesh) -> np.ndarray:
    """start (n_node, 3) with the nodes of `posterior` where they were measured, the others carried along."""
    held = np.zeros(len(start), dtype=bool)
    held[measured.boundary_nodes("posterior")] = True
    gap = np.where(held[:, None], measured.points - start, 0.0)
    return start + carried(measured.moved_to(start), gap, held) if gap.any() else start


@dataclass(frozen=True)
class Nodal:
    """u = -d at every node (Carter 2009)."""

    def driven(self, measured: TetMesh) -> np.ndarray:
        """All nodes."""
        return np.arange(len(measured.points))

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm; d is zero where x is held."""
        return -guess.d


@dataclass(frozen=True)
class PulledBack(Nodal):
    """u = -F^-1 d, F = dx/dX: the difference carried back into the stress-free shape (Eiben 2014)."""

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm."""
        u: np.ndarray = -np.einsum("nij,nj->ni", nodal_inverses(guess.mesh, guess.x), guess.d)
        return u


@dataclass(frozen=True)
class SurfaceDriven:
    """u = -d at the nodes of the skin only, carried to those inside by an elastic transform."""

    def driven(self, measured: TetMesh) -> np.ndarray:
        """The nodes of the skin that are free."""
        return np.setdiff1d(measured.boundary_nodes("skin"), measured.boundary_nodes("posterior"))

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm."""
        mesh, u = guess.mesh, np.zeros_like(guess.d)
        skin = self.driven(mesh)
        u[skin] = -guess.d[skin]
        prescribed = np.zeros(len(u), dtype=bool)
        prescribed[skin] = prescribed[mesh.boundary_nodes("posterior")] = True
        return carried(mesh, u, prescribed)


def nodal_inverses(mesh: TetMesh, x: np.ndarray) -> np.ndarray:
    """F^-1 (n_node, 3, 3) of the shape x (n_node, 3), mesh.points the reference.

    At a node, the average of F^-1 over the reference volume of its cells.
    """
    quadrature = cell_quadrature(mesh.points, mesh.cells)
    F = np.einsum("eai,eqaj->eqij", x[mesh.cells], quadrature.gradients)
    sums = np.einsum("eq,eqij->eij", quadrature.volumes, np.linalg.inv(F))
    total, weight = np.zeros((len(x), 3, 3)), np.zeros(len(x))
    np.add.at(total, mesh.cells, sums[:, None])
    np.add.at(weight, mesh.cells, quadrature.volumes.sum(axis=1)[:, None])
    return total / weight[:, None, None]


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
