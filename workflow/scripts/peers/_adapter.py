"""What every adapter does: read a problem, warm up, be timed, and hand back what was found.

Runs in the environments of other programs, so it needs numpy alone. mm, kPa, mN, keV. Gravity pulls the
hemisphere along +z; the detector of X-ray tasks lies below.
"""

import json
import resource
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

# VTK order of the nodes of a quadratic tetrahedron: corners 0-3, then the middles of these edges.
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
SMALLEST_STEP = 1 / 64


class NotConverged(Exception):
    """A program came to no answer; the first argument says why."""


@dataclass(frozen=True)
class Hemisphere:
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
    def read(cls, mesh: str, case: str) -> "Hemisphere":
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


@dataclass(frozen=True)
class XrayTask:
    """Arrays and facts as mammosim.study.peers.xray writes them; settings: of this program and run.

    path: the problem's own file, for a program that reads it itself.
    """

    path: str
    arrays: dict[str, np.ndarray]
    facts: dict[str, Any]
    settings: dict[str, Any]

    @classmethod
    def read(cls, problem: str, case: str) -> "XrayTask":
        """The problem of a file written by mammosim.io.programs."""
        with open(case) as file:
            settings = json.load(file)
        with np.load(problem) as file:
            arrays = {name: file[name] for name in file if name != "facts"}
            return cls(problem, arrays, json.loads(str(file["facts"])), settings)

    @property
    def runs(self) -> tuple[int, int, float]:
        """The least and most runs, and seconds that are enough."""
        runs = self.settings["runs"]
        return runs["least"], runs["most"], runs["enough_s"]

    def from_source(self) -> tuple[np.ndarray, float]:
        """Distance (nv, nu) of the pixels' centres from the source, and its height above the detector, mm."""
        d = {name: np.array(value) for name, value in self.facts["detector"].items()}
        rows, columns = np.indices(d["shape"])
        ends = d["origin"] + d["pixel_mm"] * (columns[..., None] * d["u"] + rows[..., None] * d["v"])
        source = np.array(self.facts["source_mm"])
        return np.linalg.norm(ends - source, axis=-1), float(source[2] - d["origin"][2])


def used(who: int) -> tuple[float, float]:
    """Largest memory [MB] and processor time [s] so far, of this process or of those it waited for."""
    usage = resource.getrusage(who)
    return usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime


class Solver(Protocol):
    """A program with the problem in its own terms; only `solve` is timed.

    It returns a Path, of which `displacements(u)` makes (n_node, 3) mm, or what `answer` makes an answer of.
    """

    def solve(self) -> Any:
        """What the program found. Raises NotConverged."""


def run(problem: type, program: Callable[[Any], Solver], *, who: int = resource.RUSAGE_SELF) -> None:
    """Solve what the command line names: problem, small problem, case, result (.npz).

    problem: Hemisphere or XrayTask; program: what solves it. It is timed as often as the problem's `runs` say
    (least, most, and the seconds that are enough), else once. Numbers of several runs are listed, of arrays
    the last stays.
    who: whose time and memory count, resource.RUSAGE_CHILDREN for a program of its own.
    The small problem is solved first, so that what is compiled or loaded once is not counted.
    """
    large, small, case, result = sys.argv[1:5]
    _found(program(problem.read(small, case)))
    given = problem.read(large, case)
    began = used(resource.RUSAGE_SELF)[1]
    solver = program(given)
    setup_s = used(resource.RUSAGE_SELF)[1] - began
    before, _ = used(who)
    least, most, enough_s = getattr(given, "runs", (1, 1, 0.0))
    runs: list[dict[str, Any]] = []
    while len(runs) < least or (len(runs) < most and sum(r["cpu_s"] for r in runs) < enough_s):
        runs.append(_timed(solver, who))
    found = runs[-1]
    if len(runs) > 1:
        found |= {name: [r[name] for r in runs] for name, value in found.items() if isinstance(value, float)}
    np.savez(result, **found, setup_s=setup_s, memory_mb=used(who)[0], memory_before_mb=before)


def _timed(solver: Solver, who: int) -> dict[str, Any]:
    seconds = [used(who)[1]]
    found = _found(solver, lambda: seconds.append(used(who)[1]))
    return {"cpu_s": seconds[1] - seconds[0], **found}


def _found(solver: Any, done: Callable[[], Any] = lambda: None) -> dict[str, Any]:
    """The answer, and that there is one; done: called when the solver has ended."""
    try:
        solved = solver.solve()
    except NotConverged as failure:
        done()
        return {"outcome": str(failure.args[0])}
    done()
    if isinstance(solved, Path):
        return {"outcome": "converged", **asdict(solved), "u": solver.displacements(solved.u)}
    return {"outcome": "converged", **solver.answer(solved)}
