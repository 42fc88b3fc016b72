"""Invariance tests: a problem turned, mirrored, scaled, renumbered, in other steps, or by another path.

Both have the same answer; `Equivalent.back` carries the shape of the changed problem to that of the original.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Annotated, Literal, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.errors import ConfigurationError
from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.settings import Count, Limits, Positive, Settings, SomeOf, Triple
from mammosim.core.tissues import CellTissues, Tissue, Tissues
from mammosim.mechanics.stage import Force, default_penalty
from mammosim.study.hard_cases.bodies import MIRRORED
from mammosim.study.hard_cases.presses import PressSetup
from mammosim.study.hard_cases.problems import TestProblem, Wall

# Nodes of a quadratic triangle with two vertices exchanged: its mirror image.
_MIRRORED_FACE = [0, 2, 1, 5, 4, 3]


@dataclass(frozen=True)
class Equivalent:
    """A changed problem; back: from its shape (n_node, 3) to the original's; by_way_of: earlier gravities."""

    problem: TestProblem
    back: Callable[[np.ndarray], np.ndarray] = lambda x: x
    by_way_of: tuple[np.ndarray, ...] = ()

    def shape(self) -> np.ndarray:
        """Its equilibrium (n_node, 3) as a shape of the original. Raises as TestProblem.solution does."""
        start = None
        for gravity in self.by_way_of:
            start = replace(self.problem, gravity=gravity).solution(start=start).x
        return self.back(self.problem.solution(start=start).x)


class InvarianceTest(Protocol):
    """A change that leaves the answer the same."""

    def of(self, problem: TestProblem) -> Equivalent:
        """The problem changed."""
        ...


@dataclass(frozen=True)
class Turned(Settings):
    """Everything turned about x, then y, then z."""

    degrees: Triple

    def of(self, problem: TestProblem) -> Equivalent:
        R = Rotation.from_euler("xyz", self.degrees, degrees=True).as_matrix()
        return Equivalent(_carried(problem, R, np.zeros(3)), lambda x: x @ R)


@dataclass(frozen=True)
class Mirrored(Settings):
    """Everything in a mirror across an axis, which turns elements inside out unless they are renumbered."""

    across: Literal["x", "y", "z"]

    def of(self, problem: TestProblem) -> Equivalent:
        M = np.diag([-1.0 if name == self.across else 1.0 for name in "xyz"])
        there = _carried(problem, M, np.zeros(3))
        boundaries = {name: _columns(faces, _MIRRORED_FACE) for name, faces in there.mesh.boundaries.items()}
        mesh = replace(there.mesh, cells=_columns(there.mesh.cells, MIRRORED), boundaries=boundaries)
        return Equivalent(replace(there, mesh=mesh), lambda x: x @ M)


def _columns(elements: np.ndarray, order: list[int]) -> np.ndarray:
    """In memory row by row, for which the kernels are compiled."""
    return np.ascontiguousarray(elements[:, order])


def _carried(problem: TestProblem, R: np.ndarray, mm: np.ndarray) -> TestProblem:
    """The problem carried from x to R x + mm, but for what is held, and the order of nodes in cells."""
    wall, press, start = problem.wall, problem.press, problem.start
    return replace(
        problem,
        mesh=problem.mesh.moved_to(problem.mesh.points @ R.T + mm),
        gravity=None if problem.gravity is None else R @ problem.gravity,
        start=None if start is None else start @ R.T + mm,
        wall=wall and replace(wall, centre=R @ wall.centre + mm, axes=R @ wall.axes),
        press=press and press.moved(R, mm),
    )


@dataclass(frozen=True)
class Shifted(Settings):
    """Everything elsewhere."""

    mm: Triple

    def of(self, problem: TestProblem) -> Equivalent:
        return Equivalent(_carried(problem, np.eye(3), np.array(self.mm)), lambda x: x - self.mm)


@dataclass(frozen=True)
class Scaled(Settings):
    """Lengths times s, stresses times c, so densities times c / s: displacements become s times as large."""

    length: Positive
    stiffness: Positive

    def of(self, problem: TestProblem) -> Equivalent:
        """Penalties are stresses over lengths."""
        s, c = self.length, self.stiffness
        skin = problem.skin and replace(
            problem.skin,
            youngs_modulus_kpa=c * problem.skin.youngs_modulus_kpa,
            thickness_mm=s * problem.skin.thickness_mm,
        )
        there = replace(
            problem,
            mesh=problem.mesh.moved_to(s * problem.mesh.points),
            tissues=_scaled_tissues(problem.tissues, s, c),
            skin=skin,
            wall=problem.wall and _scaled_wall(problem.wall, s),
            contact=problem.contact and c / s * problem.contact,
            sliding=problem.sliding and (c / s * problem.sliding[0], c / s * problem.sliding[1]),
            press=problem.press and problem.press.scaled(s, c, default_penalty(problem.effects())),
        )
        return Equivalent(there, lambda x: x / s)


def _scaled_tissues(tissues: Tissues, s: float, c: float) -> Tissues:
    if isinstance(tissues, CellTissues):
        return replace(
            tissues,
            youngs_modulus_kpa=c * tissues.youngs_modulus_kpa,
            density_g_cm3=c / s * tissues.density_g_cm3,
        )
    return {
        label: Tissue(c * t.youngs_modulus_kpa, t.poisson_ratio, c / s * t.density_g_cm3)
        for label, t in tissues.items()
    }


def _scaled_wall(wall: Wall, s: float) -> Wall:
    lengths = {f.name: s * getattr(wall, f.name) for f in fields(wall) if f.name != "axes"}
    return replace(wall, **lengths)


@dataclass(frozen=True)
class Renumbered(Settings):
    """Nodes and elements in another order."""

    seed: int

    def of(self, problem: TestProblem) -> Equivalent:
        mesh, rng = problem.mesh, generator("renumbered", str(self.seed))
        order, cells = rng.permutation(len(mesh.points)), rng.permutation(len(mesh.cells))
        new = np.argsort(order)
        other = TetMesh(
            mesh.points[order],
            new[mesh.cells[cells]],
            mesh.tissue[cells],
            {name: new[faces] for name, faces in mesh.boundaries.items()},
        )
        there = replace(
            problem,
            mesh=other,
            held=None if problem.held is None else problem.held[order],
            tissues=_in_order(problem.tissues, cells),
        )
        return Equivalent(there, lambda x: x[new])


def _in_order(tissues: Tissues, cells: np.ndarray) -> Tissues:
    """Of cells (n_cell,) in another order."""
    if not isinstance(tissues, CellTissues):
        return tissues
    return CellTissues(**{name: values[cells] for name, values in vars(tissues).items()})


@dataclass(frozen=True)
class Stepwise(Settings):
    """The load in equal steps, where the problem has it suddenly."""

    load_steps: Annotated[int, Limits(at_least=2)]

    def of(self, problem: TestProblem) -> Equivalent:
        return Equivalent(replace(problem, load_steps=self.load_steps))


@dataclass(frozen=True)
class ByWayOf(Settings):
    """The equilibrium reached from those under other directions of gravity, one after the other."""

    gravity: tuple[Triple, ...]

    def of(self, problem: TestProblem) -> Equivalent:
        return Equivalent(problem, by_way_of=tuple(np.array(g) for g in self.gravity))


@dataclass(frozen=True)
class PressedIn(Settings):
    """Between plates that approach in another number of steps."""

    steps: Count

    def of(self, problem: TestProblem) -> Equivalent:
        press = _press_of(problem)
        settings = replace(press.settings, steps=self.steps)
        return Equivalent(replace(problem, press=replace(press, settings=settings)))


@dataclass(frozen=True)
class ByItsForce(Settings):
    """Pressed to the force that the plates feel at the thickness of the problem."""

    def of(self, problem: TestProblem) -> Equivalent:
        """Raises as TestProblem.solution does."""
        press, pressed = _press_of(problem), problem.solution().pressed
        force = Force(float(pressed.path.force_n.iloc[-1])) if pressed is not None else press.control
        return Equivalent(replace(problem, press=replace(press, control=force)))


def _press_of(problem: TestProblem) -> PressSetup:
    if problem.press is None:
        raise ConfigurationError("pressed_in and by_its_force are of plates; add press to the problem")
    return problem.press


INVARIANCE_TESTS = SomeOf({
    "turned": Turned,
    "mirrored": Mirrored,
    "shifted": Shifted,
    "scaled": Scaled,
    "renumbered": Renumbered,
    "stepwise": Stepwise,
    "by_way_of": ByWayOf,
    "pressed_in": PressedIn,
    "by_its_force": ByItsForce,
})  # fmt: skip


def changed(problem: TestProblem, tests: Iterable[InvarianceTest]) -> Equivalent:
    """The problem with one change after the other."""
    found = Equivalent(problem)
    for test in tests:
        after = test.of(found.problem)
        found = Equivalent(after.problem, partial(_back, found.back, after.back), after.by_way_of)
    return found


def _back(first: Callable, second: Callable, x: np.ndarray) -> np.ndarray:
    return first(second(x))
