"""What the adapters of the X-ray tasks share: the problem they are given, and what they hand back.

Runs in the environments of other programs, so it needs numpy alone. mm, keV; the detector lies below.
"""

import json
import resource
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from _run import run as timed


@dataclass(frozen=True)
class Problem:
    """Arrays and facts as mammosim.study.peers.xray writes them; settings: of this program and run.

    path: the problem's own file, for a program that reads it itself.
    """

    path: str
    arrays: dict[str, np.ndarray]
    facts: dict[str, Any]
    settings: dict[str, Any]

    @classmethod
    def read(cls, problem: str, case: str) -> "Problem":
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


class Solver(Protocol):
    """A program with the problem in its own terms; making one is not counted, nor is `answer`."""

    def solve(self) -> Any:
        """What the program returns. Raises NotConverged."""

    def answer(self, solved: Any) -> dict[str, Any]:
        """By the names that the task asks for."""


def run(program: Callable[[Problem], Solver], *, who: int = resource.RUSAGE_SELF) -> None:
    """Solve what the command line names: problem, small problem, case, result (.npz), timed by `_run.run`."""
    timed(Problem.read, program, lambda solver, solved: solver.answer(solved), who=who)
