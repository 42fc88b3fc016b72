"""The row of one program and X-ray task: its times, and what is made of what it found."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from mammosim.study.peers.xray import Task, columns


def row_of(task: Task, found: Mapping[str, Any], relative_error: float | None) -> dict[str, Any]:
    """The row of what a program found, all nan but its outcome if it found nothing."""
    here = found["outcome"] == "converged"
    machine = {name: found.get(name, np.nan) for name in ("setup_s", "memory_mb")}
    amounts = task.amounts(found) if here else columns("")
    return times(found, relative_error) | machine | amounts | {"outcome": found["outcome"]}


def times(found: Mapping[str, Any], relative_error: float | None) -> dict[str, Any]:
    """Of the runs of a program: median, least and most processor-seconds, and what follows from them.

    seconds: the median time to relative_error, which falls as its square; histories_per_s: the median.
    """
    cpu_s = np.atleast_1d(found.get("cpu_s", np.nan))
    reached = np.atleast_1d(found.get("reached", np.nan))
    to_goal = cpu_s if relative_error is None else cpu_s * (reached / relative_error) ** 2
    histories = np.atleast_1d(found.get("histories", np.nan))
    return {
        "seconds": float(np.median(to_goal)),
        "cpu_s": float(np.median(cpu_s)),
        "cpu_least_s": float(cpu_s.min()),
        "cpu_most_s": float(cpu_s.max()),
        "runs": len(cpu_s) if "cpu_s" in found else 0,
        "histories": float(np.median(histories)),
        "histories_per_s": float(np.median(histories / cpu_s)),
        "reached": float(np.median(reached)),
    }
