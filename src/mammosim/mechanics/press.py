"""One step of a compression: body, paddle and friction in equilibrium with plates at a given distance.

Body:     dE/dx + dP/dx = 0 by the verified Newton, at given paddle q and normal forces of friction
Paddle:   R = K q + dP/dq = 0 by Newton on the Schur complement S = K + d2P/dq2 - (dx/dq) . d2E (dx/dq)
Friction: the normal forces are those of the shape found, by repetition

P is the energy of the contacts, with friction of both plates; it depends on q through the paddle's place.
"""

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.budget import BudgetSpent
from mammosim.mechanics.descent import descend
from mammosim.mechanics.effects import Effect, RigidPlate
from mammosim.mechanics.loading import lowest_mode
from mammosim.mechanics.newton import Iteration, NewtonSettings, StepFailed, System, converge, is_stable
from mammosim.mechanics.paddles import Plates
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.stage import PressSettings, Stage

log = logging.getLogger(__name__)

# Paddle: largest imbalance relative to the forces on it, at the end and before; how far its face may move in
# an iteration.
PADDLE_TOLERANCE, PATH_PADDLE_TOLERANCE = 1e-6, 1e-3
_LARGEST_MOVE_MM = 3.0
_PROBE_MM = 1e-5  # of finite differences by q
_MOST_BALANCES = 25
# How far tissue is moved at most along the mode of an unstable shape.
_ASIDE_MM = 0.5
# Relative residuals to which the energy is lowered where Newton fails, first and again.
_DOWNHILL = (1e-3, 1e-6)
_MOST_LAGS = 25
# How often the multipliers of contact are updated; one that gains less than a fourth also raises the penalty.
_MOST_UPDATES = 8


@dataclass(frozen=True)
class _Response:
    """S (m, m) = dR/dq with the body following, and how it follows, V = dx/dq (m, n_node, 3)."""

    S: np.ndarray
    V: np.ndarray

    def updated(self, dq: np.ndarray, dR: np.ndarray) -> "_Response":
        """S that has the change dR by dq which was found, otherwise as before (Broyden 1965)."""
        return replace(self, S=self.S + np.outer(dR - self.S @ dq, dq) / (dq @ dq))


@dataclass(frozen=True)
class Press:
    """What stays the same while a body is pressed: body, plates, and how it is solved.

    apart: plates without contact, which the pattern of the system knows.
    """

    system: System
    effects: tuple[Effect, ...]
    apart: tuple[RigidPlate, RigidPlate]
    plates: Plates
    settings: PressSettings

    def pressed(self, before: Sequence[Stage], thickness: float, *, on_the_way: bool = False) -> Stage:
        """The stage at a thickness after others, pressed skin near enough to the plates. Raises StepFailed.

        on_the_way: others follow, so that path_penetration is near enough.
        """
        began = time.perf_counter()
        self.plates.require_apart(thickness, before[-1].q)
        self._require_clear_of_held_skin(before[-1], thickness)
        history: list[Iteration] = []
        last = before[-1].augmented()
        friction_states = tuple(
            friction_state.lagged(contact, last.x)
            for friction_state, contact in zip(last.friction_states, last.contacts)
        )
        stage = replace(
            self._guess([*before[:-1], last], thickness),
            friction_states=friction_states,
            dissipated=last.dissipated,
        )
        near = self.settings.penetration_mm
        if on_the_way and not self.plates.friction:  # friction depends on the whole path
            near = max(near, self.settings.path_penetration * abs(thickness - last.thickness))
        stage = self._in_contact(stage, near, history)
        if not is_stable(self._system(stage), stage.x):
            stage = self._off_the_saddle(stage, last, near, history)
        self.system.spending.succeed()
        stage = replace(stage, history=tuple(history), seconds=time.perf_counter() - began)
        return self._carried(stage)

    def _off_the_saddle(self, stage: Stage, last: Stage, near_mm: float, history: list[Iteration]) -> Stage:
        """The stable stage where an unstable one comes to rest when it is moved along its lowest mode.

        last: a stable one. Raises StepFailed, which tells the mode.
        """
        system = self._system(stage)
        mode = lowest_mode(system, stage.x, last.x)
        aside = [stage.x + side * _ASIDE_MM * mode.shape for side in (1, -1)]
        x = min(aside, key=system.potential.energy)
        unstable = StepFailed(f"the shape found is unstable: {mode.words(last.x)}", stage.x, indefinite=True)
        try:
            moved = replace(stage, x=descend(system, x, history, enough=_DOWNHILL[0]))
            moved = self._in_contact(moved, near_mm, history)
        except (StepFailed, BudgetSpent) as lost:
            raise unstable from lost
        if not is_stable(self._system(moved), moved.x):
            raise unstable
        return moved

    def settled(self, stages: Sequence[Stage]) -> Stage:
        """The last of the stages, at the same thickness, pressed skin as near to the plates as in the end."""
        last = stages[-1]
        if last.gap_error <= self.settings.penetration_mm:
            return last
        again = self.pressed(stages, last.thickness)
        return replace(again, history=(*last.history, *again.history), seconds=last.seconds + again.seconds)

    def _in_contact(self, stage: Stage, near_mm: float, history: list[Iteration]) -> Stage:
        """The stage in equilibrium, with multipliers by which pressed skin lies on the plates within near_mm.

        An update that brings it less than four times as near is followed by a fourfold penalty. The paddle
        comes to rest in the end, where it yields: before, its place need not be exact.
        """
        last_one = near_mm <= self.settings.penetration_mm
        before = np.inf
        for _ in range(_MOST_UPDATES + 1):
            stage = self._with_friction(stage, history, PATH_PADDLE_TOLERANCE)
            if last_one and self.plates.paddle.unknowns and stage.gap_error <= near_mm:
                stage = self._with_friction(stage, history, PADDLE_TOLERANCE)
            gap_error = stage.gap_error
            if gap_error <= near_mm:
                return stage
            raised = 4 if gap_error > before / 4 else 1
            paddle, support = (
                replace(c.augmented(stage.x), penalty=raised * c.penalty) for c in stage.contacts
            )
            stage, before = replace(stage, contacts=(paddle, support)), gap_error
        raise StepFailed(f"the skin is {gap_error:.2f} mm away from a plate that presses it", stage.x)

    def finished(self, stage: Stage) -> Stage:
        """The stage to the full tolerance, by plain steps: so near, energies differ by rounding alone."""
        newton, history = self.settings.solver.newton, list(stage.history)
        newton = replace(newton, trusted=newton.max_iterations)
        return replace(
            stage, x=converge(self._system(stage), stage.x, newton, history), history=tuple(history)
        )

    @property
    def _newton(self) -> NewtonSettings:
        newton = self.settings.solver.newton
        if self.plates.paddle.unknowns:
            return newton
        return replace(newton, tolerance=max(newton.tolerance, self.settings.path_tolerance))

    def _require_clear_of_held_skin(self, last: Stage, thickness: float) -> None:
        """Raise MechanicsError where held skin, which nothing can push out, would be in a plate."""
        nodes = np.unique(self.apart[0].faces)
        nodes = nodes[self.system.held[nodes].all(axis=1)]
        if len(nodes) == 0:
            return
        depth = -min(box.distance(last.x[nodes]).min() for box in self.plates.at(thickness, last.q))
        if depth > self.settings.penetration_mm:
            raise MechanicsError(
                f"the plates meet the chest wall: at {thickness:.1f} mm, held skin would be {depth:.1f} mm "
                "inside one of them; move their chest edge outward (chest_gap_mm), or ask for more thickness"
            )

    def _carried(self, stage: Stage) -> Stage:
        """The stage with the friction states that the next one begins with."""
        after = [
            friction_state.carried(contact, stage.x)
            for friction_state, contact in zip(stage.friction_states, stage.contacts)
        ]
        dissipated = stage.dissipated + sum(lost for _, lost in after)
        return replace(
            stage, friction_states=tuple(friction_state for friction_state, _ in after), dissipated=dissipated
        )

    def _guess(self, before: Sequence[Stage], thickness: float) -> Stage:
        """Shape and paddle along the line of the last two stages, as far as J stays above half."""
        last = before[-1]
        stage = self._moved(replace(last, thickness=thickness), last.q)
        if len(before) < 2 or thickness == last.thickness:
            return stage
        other = before[-2]
        part = (thickness - last.thickness) / (last.thickness - other.thickness)
        least = min(1.0, self._system(last).potential.smallest_J(last.x)) / 2
        while abs(part) > 1e-3:
            x = last.x + part * (last.x - other.x)
            if self._system(last).potential.smallest_J(x) >= least:
                return replace(self._moved(stage, last.q + part * (last.q - other.q)), x=x)
            part /= 2
        return stage

    def _moved(self, stage: Stage, q: np.ndarray) -> Stage:
        """The stage with its paddle moved to q."""
        boxes = self.plates.at(stage.thickness, q)
        paddle, support = (replace(contact, obstacle=box) for contact, box in zip(stage.contacts, boxes))
        return replace(stage, q=q, contacts=(paddle, support))

    def _system(self, stage: Stage) -> System:
        return replace(self.system, potential=Potential((*self.effects, *stage.surroundings())))

    def _with_friction(self, stage: Stage, history: list[Iteration], tolerance: float) -> Stage:
        """The stage in equilibrium under friction forces that belong to its own normal forces.

        tolerance: of the forces on the paddle.
        """
        for _ in range(_MOST_LAGS):
            stage = self._balanced(stage, history, tolerance)
            if not stage.friction_states:
                return stage
            friction_states = tuple(
                friction_state.lagged(c, stage.x)
                for friction_state, c in zip(stage.friction_states, stage.contacts)
            )
            after = replace(stage, friction_states=friction_states)
            if self._friction_change(stage, after) <= self.settings.friction_tolerance:
                return stage
            stage = after
        raise StepFailed("friction and normal forces did not agree", stage.x)

    def _friction_change(self, stage: Stage, after: Stage) -> float:
        """Of the friction forces on the nodes, relative to the forces of contact."""
        old, new = (
            Potential(state.surroundings()[len(state.contacts) :]).gradient(stage.x)
            for state in (stage, after)
        )
        pressing = np.linalg.norm(Potential(stage.contacts).gradient(stage.x))
        scale = max(float(pressing), float(np.linalg.norm(old)))
        return float(np.linalg.norm(new - old)) / scale if scale else 0.0

    def _balanced(self, stage: Stage, history: list[Iteration], tolerance: float) -> Stage:
        """Body and paddle in equilibrium: S exact at first, then updated, as contact has kinks."""
        stage = replace(stage, x=self._settled(self._system(stage), stage.x, history))
        R, scale = self._paddle_forces(stage)
        response: _Response | None = None
        for _ in range(_MOST_BALANCES):
            if np.all(np.abs(R) <= tolerance * scale):
                return stage
            response = response or self._response(stage)
            dq = self._paddle_step(response, R)
            stage = self._followed(stage, dq, response)
            stage = replace(stage, x=self._settled(self._system(stage), stage.x, history))
            before = R
            R, scale = self._paddle_forces(stage)
            response = response.updated(dq, R - before)
        raise StepFailed(f"the paddle did not come to rest: {np.abs(R).max():.3g} mN are left", stage.x)

    def _settled(self, system: System, x: np.ndarray, history: list[Iteration]) -> np.ndarray:
        """The body in equilibrium, by way of a descent where Newton alone does not succeed."""
        newton = self._newton
        for enough in _DOWNHILL:
            try:
                return converge(system, x, newton, history)
            except StepFailed as failure:
                log.info("downhill, since Newton failed: %s", failure)
                x = descend(system, failure.x, history, enough=enough)
        return converge(system, x, newton, history)

    def _paddle_forces(self, stage: Stage) -> tuple[np.ndarray, np.ndarray]:
        """R (m,) = K q + dP/dq, and what it is measured against."""
        K = self.plates.paddle.stiffness(self.plates.half_sizes)
        reach = self.plates.paddle.reach(self.plates.half_sizes)
        scale = np.linalg.norm(stage.contacts[0].state(stage.x).force) * reach
        return K @ stage.q + self._contact_forces(stage), np.maximum(scale, 1.0)

    def _contact_forces(self, stage: Stage) -> np.ndarray:
        """dP/dq (m,) at fixed x."""
        return np.array(
            [
                (self._energy(stage, stage.q + dq) - self._energy(stage, stage.q - dq))
                / (2 * np.abs(dq).sum())
                for dq in self._probes()
            ]
        )

    def _probes(self) -> np.ndarray:
        """Small changes of q (m, m), one a row."""
        return np.diag(_PROBE_MM / self.plates.paddle.reach(self.plates.half_sizes))

    def _energy(self, stage: Stage, q: np.ndarray) -> float:
        return Potential(self._moved(stage, q).surroundings()).energy(stage.x)

    def _paddle_step(self, response: "_Response", R: np.ndarray) -> np.ndarray:
        """dq (m,) = - S^-1 R, cut where the face would move too far."""
        dq = -np.linalg.solve(response.S, R)
        reach = self.plates.paddle.reach(self.plates.half_sizes)
        return dq * min(1.0, _LARGEST_MOVE_MM / float(np.abs(dq * reach).sum()))

    def _followed(self, stage: Stage, dq: np.ndarray, response: "_Response") -> Stage:
        """The paddle moved by dq, and the body with it where J stays positive."""
        moved = self._moved(stage, stage.q + dq)
        x = stage.x + np.einsum("m,mai->ai", dq, response.V)
        return replace(moved, x=x) if self._system(moved).potential.smallest_J(x) > 0 else moved

    def _response(self, stage: Stage) -> "_Response":
        """Of paddle and body to small changes of q."""
        probes = self._probes()
        V = self._following(stage, probes)
        columns = []
        for dq, dx in zip(probes, V):
            ahead, behind = (
                self._contact_forces(replace(self._moved(stage, stage.q + s * dq), x=stage.x + s * dx))
                for s in (1, -1)
            )
            columns.append((ahead - behind) / (2 * np.abs(dq).sum()))
        K = self.plates.paddle.stiffness(self.plates.half_sizes)
        return _Response(K + np.array(columns).T, V / np.diag(probes)[:, None, None])

    def _following(self, stage: Stage, probes: np.ndarray) -> np.ndarray:
        """How the body follows small changes of q: (m, n_node, 3) of K dx = - d2P/dxdq dq."""
        system, solver = self._system(stage), self.system.solver
        K = system.potential.tangent(stage.x, system.pattern)
        found: list[np.ndarray] = []
        for dq in probes:
            ahead, behind = (self._pull(stage, stage.q + s * dq) for s in (1, -1))
            g = (ahead - behind).ravel()[system.rows.free] / 2
            solve = solver.again if found else lambda b, accuracy: solver.solve(K, b, accuracy)
            found.append(system.spread(solve(-g, 1e-4)))
        K.give_back()
        return np.array(found)

    def _pull(self, stage: Stage, q: np.ndarray) -> np.ndarray:
        """dP/dx (n_node, 3) with the paddle at q."""
        return Potential(self._moved(stage, q).surroundings()).gradient(stage.x)
