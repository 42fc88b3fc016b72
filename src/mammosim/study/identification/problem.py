"""Moduli from two measured positions: maximum a posteriori, with their covariance.

The body is unloaded from the start by the inverse formulation and loaded in the goal. The residual r of
study.identification.pair and the prior make

    Phi = |r(theta)|^2 / 2 + sum_j ((theta_j - theta0_j) / s_j)^2 / 2

minimised by Gauss-Newton in study.identification.fit. theta: ln E by side and tissue, and what else
is uncertain and moves the prediction, so that its error enters the intervals: nu, and the rigid motion that
registration left. Derivatives are those of both equilibria, R(X, theta) = 0 prone, S(x, X, theta) = 0 supine:

    J X' = - dR/dtheta,   K x' = - (dS/dtheta + dS/dX X')
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mammosim.mechanics.analysis import system_of
from mammosim.mechanics.body import Body
from mammosim.mechanics.equilibrium import held_nodes
from mammosim.mechanics.inverse import Measured, inverse, linearised
from mammosim.mechanics.potential import Potential
from mammosim.study.identification.moduli import KEYS, Materials, Moduli
from mammosim.study.identification.pair import Pair
from mammosim.study.identification.settings import Errors, Prior

N_MODULI = len(KEYS)
OTHERS = ("poisson_ratio", "shift_x_mm", "shift_y_mm", "shift_z_mm", "turn_x_deg", "turn_y_deg", "turn_z_deg")
MECHANICAL = N_MODULI + 1  # parameters that change the equilibria: the moduli and nu
# Difference from which derivatives by a parameter are taken: of ln E, and downward of nu.
_STEP = 1e-4
_SENSITIVITY_ACCURACY, _FORWARD_ACCURACY = 0.05, 1e-4


@dataclass(frozen=True)
class State:
    """A prediction: theta (15,), rest and x (n_node, 3) mm, stress-free and in the goal's position."""

    theta: np.ndarray
    rest: np.ndarray
    x: np.ndarray


@dataclass(frozen=True)
class Sensitivities:
    """d rest / d theta and d x / d theta (9, n_node, 3) of the mechanical parameters."""

    rest: np.ndarray
    x: np.ndarray

    def beside(self, state: State, step: np.ndarray) -> State:
        """The state after a step of theta (15,), to first order."""
        rest, x = (np.tensordot(step[:MECHANICAL], slope, axes=1) for slope in (self.rest, self.x))
        return State(state.theta + step, state.rest + rest, state.x + x)


@dataclass(frozen=True)
class Problem:
    """A pair to be explained; assumed: what the fit takes as known of tissues and skin (see Moduli.body).

    model_error: standard deviation of ln E by tissue that the model itself adds, alike on both sides.
    """

    pair: Pair
    assumed: Materials
    prior: Prior
    model_error: Mapping[str, float] = field(default_factory=dict)
    middle_mm: float = 0.0

    def body(self, theta: np.ndarray) -> Body:
        """The body with these moduli and this nu."""
        moduli = Moduli.of_logarithms(theta[:N_MODULI])
        mesh = self.pair.start.mesh
        return moduli.body(mesh, self.assumed, middle_mm=self.middle_mm, poisson_ratio=theta[N_MODULI])

    def predicted(self, theta: np.ndarray, near: State | None = None) -> State:
        """The body unloaded from the start and loaded in the goal's position. Raises EquilibriumError."""
        start, goal, body = self.pair.start, self.pair.goal, self.body(theta)
        rest = inverse(start.mesh, body, gravity=start.gravity, start=near.rest if near else None).points
        state = body.load(start.mesh.moved_to(rest), goal.gravity, start=near.x if near else None)
        return State(theta, rest, state.points)

    def from_rest(self, state: State) -> State:
        """The same state, loaded once more from rest along stable equilibria. Raises EquilibriumError."""
        mesh, gravity = self.pair.start.mesh.moved_to(state.rest), self.pair.goal.gravity
        return State(state.theta, state.rest, self.body(state.theta).load(mesh, gravity).points)

    def residual(self, state: State, errors: Errors) -> np.ndarray:
        """r (n,) of a prediction, the goal moved rigidly by the parameters of theta."""
        pair = self.pair
        x = self._moved_back(state.theta, state.x)
        nodes, q, n = pair.contacts(x)
        skin, marker = pair.weights(nodes, errors)
        m = self._moved_back(state.theta, pair.marker_places(state.x)) - pair.goals
        return np.concatenate([skin * np.sum(n * (x[nodes] - q), axis=1), marker * m.ravel()])

    def news(self, state: State) -> np.ndarray:
        """(n,) how much of an independent distance each of the skin's rows of the residual stands for."""
        pair = self.pair
        nodes, _, _ = pair.contacts(self._moved_back(state.theta, state.x))
        return pair.weights(nodes, Errors(1.0, 1.0))[0] ** 2

    def slopes(self, state: State, changes: Sensitivities, errors: Errors) -> np.ndarray:
        """dr/dtheta (n, 15), by the changes of the equilibria and the rigid motion."""
        pair = self.pair
        nodes, _, n = pair.contacts(self._moved_back(state.theta, state.x))
        skin, marker = pair.weights(nodes, errors)
        places, h = pair.marker_places(state.x), 1e-3
        columns = [(dx[nodes], (pair.marker_places(state.x + h * dx) - places) / h) for dx in changes.x]
        for axis in np.eye(3):
            columns.append((np.broadcast_to(-axis, (len(nodes), 3)), np.broadcast_to(-axis, places.shape)))
        for axis in np.radians(1) * np.eye(3):
            columns.append((-np.cross(axis, state.x[nodes]), -np.cross(axis, places)))
        return np.stack(
            [np.concatenate([skin * np.sum(n * v, axis=1), marker * w.ravel()]) for v, w in columns], axis=1
        )

    def _moved_back(self, theta: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in the frame of a goal that registration left shifted and turned, to first order."""
        shift, turn = theta[MECHANICAL : MECHANICAL + 3], np.radians(theta[MECHANICAL + 3 :])
        return points - shift - np.cross(turn, points)

    def sensitivities(self, state: State) -> Sensitivities:
        """Derivatives of both equilibria at a state."""
        varied = [self._varied(state.theta, j) for j in range(MECHANICAL)]
        rest = self._rest_slopes(state, varied)
        return Sensitivities(rest, self._x_slopes(state, varied, rest))

    def _rest_slopes(self, state: State, varied: list[tuple[Body, float]]) -> np.ndarray:
        """X' (9, n_node, 3), J X' = - dR/dtheta."""
        mesh, gravity = self.pair.start.mesh, self.pair.start.gravity
        with linearised(Measured(mesh, self.body(state.theta), gravity), state.rest) as at:
            R = [(Measured(mesh, body, gravity).forces(state.rest) - at.R) / h for body, h in varied]
            return np.array([at.solved(-slope, _SENSITIVITY_ACCURACY) for slope in R])

    def _x_slopes(self, state: State, varied: list[tuple[Body, float]], rest: np.ndarray) -> np.ndarray:
        """x' (9, n_node, 3), K x' = - (dS/dtheta + dS/dX X'), with rest: X' (9, n_node, 3)."""
        potential = self._under_goal(self.body(state.theta), state.rest)
        S = potential.gradient(state.x)
        slopes: list[np.ndarray] = []
        with system_of(potential, held_nodes(self.pair.start.mesh)) as system:
            K = potential.tangent(state.x, system.pattern)
            for (body, h), change in zip(varied, rest):
                there = self._under_goal(body, state.rest + h * change).gradient(state.x)
                b = -((there - S) / h).ravel()[system.rows.free]
                solver = system.solver
                dx = solver.again(b, _FORWARD_ACCURACY) if slopes else solver.solve(K, b, _FORWARD_ACCURACY)
                slopes.append(system.spread(dx))
            K.give_back()
        return np.array(slopes)

    def _under_goal(self, body: Body, X: np.ndarray) -> Potential:
        """The potential of a body with the reference X (n_node, 3) in the goal's position."""
        mesh = self.pair.start.mesh.moved_to(X)
        return Potential(body.effects(mesh), (body.weight(mesh, self.pair.goal.gravity),))

    def _varied(self, theta: np.ndarray, j: int) -> tuple[Body, float]:
        """The body with one mechanical parameter changed, and by how much."""
        h = -_STEP if j == N_MODULI else _STEP
        return self.body(theta + h * np.eye(len(theta))[j]), h
