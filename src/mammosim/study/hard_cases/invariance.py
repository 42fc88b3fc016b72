"""Invariance tests: a problem turned, scaled, renumbered, loaded in steps, or reached by another path.

Both have the same answer; `Equivalent.back` carries the shape of the changed problem to that of the original.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Annotated, Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.settings import Limits, Positive, Settings, SomeOf, Triple
from mammosim.core.tissues import Tissue
from mammosim.study.hard_cases.problems import TestProblem, Wall


@dataclass(frozen=True)
class Equivalent:
    """A changed problem; back: from its shape (n_node, 3) to the original's; by_way_of: earlier gravities."""

    problem: TestProblem
    back: Callable[[np.ndarray], np.ndarray] = lambda x: x
    by_way_of: tuple[np.ndarray, ...] = ()

    def shape(self) -> np.ndarray:
        """Its equilibrium (n_node, 3) as a shape of the original. Raises as TestProblem.equilibrium does."""
        start = None
        for gravity in self.by_way_of:
            start = replace(self.problem, gravity=gravity).equilibrium(start=start).points
        return self.back(self.problem.equilibrium(start=start).points)


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
        wall, plates = problem.wall, problem.plates
        wall = wall and replace(wall, centre=R @ wall.centre, axes=R @ wall.axes)
        plates = plates and replace(plates, centre=R @ plates.centre, axes=R @ plates.axes)
        gravity = None if problem.gravity is None else R @ problem.gravity
        mesh = problem.mesh.moved_to(problem.mesh.points @ R.T)
        there = replace(problem, mesh=mesh, gravity=gravity, wall=wall, plates=plates)
        return Equivalent(there, lambda x: x @ R)


@dataclass(frozen=True)
class Shifted(Settings):
    """Everything elsewhere."""

    mm: Triple

    def of(self, problem: TestProblem) -> Equivalent:
        wall = problem.wall and replace(problem.wall, centre=problem.wall.centre + self.mm)
        there = replace(problem, mesh=problem.mesh.moved_to(problem.mesh.points + self.mm), wall=wall)
        return Equivalent(there, lambda x: x - self.mm)


@dataclass(frozen=True)
class Scaled(Settings):
    """Lengths times s, stresses times c, so densities times c / s: displacements become s times as large."""

    length: Positive
    stiffness: Positive

    def of(self, problem: TestProblem) -> Equivalent:
        """Penalties are stresses over lengths."""
        s, c = self.length, self.stiffness
        tissues = {
            label: Tissue(c * t.youngs_modulus_kpa, t.poisson_ratio, c / s * t.density_g_cm3)
            for label, t in problem.tissues.items()
        }
        skin = problem.skin and replace(
            problem.skin,
            youngs_modulus_kpa=c * problem.skin.youngs_modulus_kpa,
            thickness_mm=s * problem.skin.thickness_mm,
        )
        there = replace(
            problem,
            mesh=problem.mesh.moved_to(s * problem.mesh.points),
            tissues=tissues,
            skin=skin,
            wall=problem.wall and _scaled_wall(problem.wall, s),
            contact=problem.contact and c / s * problem.contact,
            sliding=problem.sliding and (c / s * problem.sliding[0], c / s * problem.sliding[1]),
        )
        return Equivalent(there, lambda x: x / s)


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
        held = None if problem.held is None else problem.held[order]
        return Equivalent(replace(problem, mesh=other, held=held), lambda x: x[new])


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


INVARIANCE_TESTS = SomeOf({
    "turned": Turned,
    "shifted": Shifted,
    "scaled": Scaled,
    "renumbered": Renumbered,
    "stepwise": Stepwise,
    "by_way_of": ByWayOf,
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
