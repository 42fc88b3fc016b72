"""What a job asks of a cluster: what the largest job of its rule was measured to take, with room.

R = 2^(attempt - 1) (r M + S), with M the MB of that job, r the room and S what starts it; likewise the time.
"""

from collections.abc import Mapping
from dataclasses import dataclass

# Measured: Snakemake starts twice in a job and waits in 140 to 190 MB each; srun and shells take the rest.
STARTS_MB = 450
START_S = 15.0  # two starts of at most 3 s, on a node that is busy or reads its files over the network
# ASSUME: a woman larger than those measured, or a finer mesh, takes half as much again, and what takes even
# more is tried again with twice as much.
ROOM = 1.5
# ASSUME: a node is at most three times slower than the machine of the measurement, and another woman or
# strategy takes at most twice as long as the longest of those that were measured.
SLOWER, LONGER = 3.0, 2.0
STEP_MB = 100
LEAST_MB = 200.0  # Python with numpy and pandas; a job of a moment ends before its memory is measured
LEAST_MIN = 10  # of a shorter one no scheduler starts earlier
# A job that is shorter than its two starts of Snakemake would be runs beside Snakemake, not on the cluster.
SHORT_S, SMALL_MB = 4.0, 700.0


@dataclass(frozen=True)
class Request:
    """Of one rule: processor seconds and MB of its longest and largest jobs, and the MB that the rule states.

    seconds, memory_mb: None where nothing was measured; then what is stated counts.
    """

    stated_mb: float
    seconds: float | None = None
    memory_mb: float | None = None

    def mem_mb(self, attempt: int) -> int:
        """MB of a job: twice as much with each attempt."""
        needed = self.stated_mb if self.memory_mb is None else max(ROOM * self.memory_mb, LEAST_MB)
        steps = -(-(needed + STARTS_MB) // STEP_MB)
        return int(steps * STEP_MB * 2 ** (attempt - 1))

    def runtime(self, attempt: int, default_min: int = 60) -> int:
        """Minutes by the clock: twice as many with each attempt."""
        least = default_min if self.seconds is None else LEAST_MIN
        needed = 0.0 if self.seconds is None else SLOWER * LONGER * self.seconds + START_S
        return max(least, int(-(-needed // 60))) * 2 ** (attempt - 1)

    @property
    def short(self) -> bool:
        """Whether a job of its own would cost more than the work."""
        if self.seconds is None or self.memory_mb is None:
            return False
        return self.seconds <= SHORT_S and self.memory_mb <= SMALL_MB


def requests(stated: Mapping[str, float], costs: Mapping[str, Mapping[str, str]]) -> dict[str, Request]:
    """Rule -> what its jobs ask for. stated: rule -> MB; costs: rule -> its line of config/costs.tsv."""

    def measured(rule: str, column: str) -> float | None:
        text = costs.get(rule, {}).get(column, "")
        return float(text) if text else None

    return {
        rule: Request(mb, measured(rule, "longest") or measured(rule, "seconds"), measured(rule, "memory_mb"))
        for rule, mb in stated.items()
    }
