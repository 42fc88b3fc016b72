"""What the adapters of the hemisphere share: the problem they are given, and what they hand back.

Runs in the environments of other programs, so it needs numpy alone. mm, kPa, mN; gravity pulls along +z.
"""

import json
import resource
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from _run import NotConverged
from _run import run as timed

# VTK order of the nodes of a quadratic tetrahedron: corners 0-3, then the middles of these edges.
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
SMALLEST_STEP = 1 / 64


@dataclass(frozen=True)
class Problem:
    """points (n_node, 3); cells (n_cell, 10) in VTK order; tissue (n_cell,); boundaries name -> (n_face, 6).

    case: as mammosim.study.peers.mechanics writes it, with the tolerance of the relative residual, and
    load_steps, how many equal ones to begin with.
    """

    points: np.ndarray
    cells: np.ndarray
    tissue: np.ndarray
    boundaries: dict[str, np.ndarray]
    case: dict

    @classmethod
    def read(cls, mesh: str, case: str) -> "Problem":
        """The problem of a mesh written by mammosim.io.meshes."""
        with open(case) as file:
            values = json.load(file)
        with np.load(mesh) as arrays:
            faces = {name[9:]: arrays[name] for name in arrays if name.startswith("boundary_")}
            return cls(arrays["points"], arrays["cells"], arrays["tissue"], faces, values)

    @cached_property
    def held(self) -> np.ndarray:
        """(n_held,) nodes."""
        return np.unique(self.boundaries["posterior"])

    @cached_property
    def mu(self) -> np.ndarray:
        """Shear modulus (n_cell,) kPa."""
        return np.array([self.case["mu_kpa"][str(label)] for label in self.tissue])

    @cached_property
    def k(self) -> np.ndarray:
        """Bulk modulus (n_cell,) kPa."""
        return np.array([self.case["k_kpa"][str(label)] for label in self.tissue])

    @property
    def weight(self) -> float:
        """Of a unit of reference volume, along +z, mN/mm3."""
        return self.case["weight"]

    @property
    def tolerance(self) -> float:
        """Of the residual, relative."""
        return self.case["tolerance"]

    @property
    def load_steps(self) -> int:
        """How many equal steps to begin with."""
        return self.case["load_steps"]

    def same_material(self) -> list[np.ndarray]:
        """The cells of each material."""
        materials, which = np.unique(np.column_stack([self.mu, self.k]), axis=0, return_inverse=True)
        return [np.flatnonzero(which.ravel() == i) for i in range(len(materials))]

    def middle_nodes(self) -> dict[tuple[int, int], int]:
        """The node in the middle of each edge, by its ends, the lower one first."""
        ends = np.sort(self.cells[:, EDGES].reshape(-1, 2), axis=1)
        return dict(zip(map(tuple, ends.tolist()), self.cells[:, 4:].ravel().tolist()))


@dataclass
class Path:
    """Where a program has come to: its unknowns, load steps done, and Newton iterations, failed ones too."""

    u: np.ndarray
    load_steps: int = 0
    newton_iterations: int = 0


def in_load_steps(
    step: Callable[[np.ndarray, float], tuple[np.ndarray, int]], u: np.ndarray, count: int
) -> Path:
    """The unknowns under full load, in equal steps, of which one that fails is halved.

    step: from unknowns and a load factor to new ones and iterations, or raises NotConverged(why, iterations).
    """
    path, reached, size = Path(u), 0.0, 1 / count
    while reached < 1 - 1e-12:
        target = min(1.0, reached + size)
        try:
            path.u, iterations = step(path.u.copy(), target)
            path.load_steps += 1
            reached = target
        except NotConverged as failure:
            iterations = failure.args[1]
            size = (target - reached) / 2
            if size < SMALLEST_STEP:
                raise NotConverged(f"no step beyond {reached:.3f} of the load: {failure.args[0]}") from None
        path.newton_iterations += iterations
    return path


class Solver(Protocol):
    """A program with the problem in its own terms; making one is not counted, nor is `displacements`."""

    def solve(self) -> Path:
        """The unknowns under full load, in the program's own order. Raises NotConverged."""

    def displacements(self, u: np.ndarray) -> np.ndarray:
        """(n_node, 3) mm of the unknowns."""


def run(program: Callable[[Problem], Solver], *, who: int = resource.RUSAGE_SELF) -> None:
    """Solve what the command line names: mesh, coarse mesh, case, result (.npz), timed as `_run.run` says."""
    timed(Problem.read, program, _answer, who=who)


def _answer(solver: Solver, path: Path) -> dict:
    return asdict(path) | {"u": solver.displacements(path.u)}
