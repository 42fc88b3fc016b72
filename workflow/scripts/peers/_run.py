"""What every adapter does: read a problem, warm up, be timed, and hand back what was found.

Runs in the environments of other programs, so it needs numpy alone.
"""

import resource
import sys
from collections.abc import Callable
from typing import Any

import numpy as np


class NotConverged(Exception):
    """A program came to no answer; the first argument says why."""


def used(who: int) -> tuple[float, float]:
    """Largest memory [MB] and processor time [s] so far, of this process or of those it waited for."""
    usage = resource.getrusage(who)
    return usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime


def run(
    read: Callable[[str, str], Any],
    program: Callable[[Any], Any],
    answer: Callable[[Any, Any], dict[str, Any]],
    *,
    who: int = resource.RUSAGE_SELF,
) -> None:
    """Solve what the command line names: problem, small problem, case, result (.npz).

    read: from the names of a problem and the case; program: what solves it, as `solve()`; answer: of the
    solver and what it returned, by name. Only `solve` is timed, as often as the problem's `runs` say (least,
    most, and the seconds that are enough), else once. Numbers of several runs are listed, of arrays the last
    stays.
    who: whose time and memory count, resource.RUSAGE_CHILDREN for a program of its own.
    The small problem is solved first, so that what is compiled or loaded once is not counted.
    """
    problem, small, case, result = sys.argv[1:5]
    _found(program(read(small, case)), answer)
    given = read(problem, case)
    began = used(resource.RUSAGE_SELF)[1]
    solver = program(given)
    setup_s = used(resource.RUSAGE_SELF)[1] - began
    before, _ = used(who)
    least, most, enough_s = getattr(given, "runs", (1, 1, 0.0))
    runs: list[dict[str, Any]] = []
    while len(runs) < least or (len(runs) < most and sum(r["cpu_s"] for r in runs) < enough_s):
        runs.append(_timed(solver, answer, who))
    found = runs[-1]
    if len(runs) > 1:
        found |= {name: [r[name] for r in runs] for name, value in found.items() if isinstance(value, float)}
    np.savez(result, **found, setup_s=setup_s, memory_mb=used(who)[0], memory_before_mb=before)


def _timed(solver: Any, answer: Callable[[Any, Any], dict[str, Any]], who: int) -> dict[str, Any]:
    seconds = [used(who)[1]]
    found = _found(solver, answer, lambda: seconds.append(used(who)[1]))
    return {"cpu_s": seconds[1] - seconds[0], **found}


def _found(
    solver: Any, answer: Callable[[Any, Any], dict[str, Any]], done: Callable[[], Any] = lambda: None
) -> dict[str, Any]:
    """The answer, and that there is one; done: called when the solver has ended."""
    try:
        solved = solver.solve()
    except NotConverged as failure:
        done()
        return {"outcome": str(failure.args[0])}
    done()
    return {"outcome": "converged", **answer(solver, solved)}
