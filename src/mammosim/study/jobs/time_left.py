"""The time a run will still take: what its jobs cost, learned while they end, shared out over the cores."""

import heapq
import math
from collections.abc import Collection, Container, Hashable, Iterable, Mapping
from contextlib import suppress
from graphlib import TopologicalSorter
from pathlib import Path

UNKNOWN_S = 2.0  # a job of a rule that nothing is known of
# ASSUME: half a minute of one rule's jobs tells how fast the machine is; a shorter job mostly loads programs.
TELLING_S = 30.0
TABLE_JOBS = 1.0  # the table counts for a rule like so many of its jobs
TABLE_RULES = 1.0  # "this machine is as fast as the table's" counts like so many rules of long jobs
LATE = 0.25  # a job that runs longer than expected will take this part of its time so far once more

Graph = Mapping[Hashable, Collection[Hashable]]  # job -> the jobs that must end before it begins
Times = dict[str, list[float]]  # rule -> seconds of each of its jobs


class TimeLeft:
    """What is left of a run, from the jobs that began and ended in it. Times are seconds of one clock.

    table: seconds of one job by rule, as measured once, perhaps on another machine; cores: jobs at a time.
    """

    def __init__(self, table: Mapping[str, float], cores: int) -> None:
        self.table, self.cores = table, cores
        self.times: Times = {}
        self.running: dict[Hashable, tuple[str, float]] = {}

    def begin(self, job: Hashable, rule: str, now: float) -> None:
        """A job has begun."""
        self.running[job] = rule, now

    def end(self, job: Hashable, now: float) -> None:
        """A job has ended, well: what it took is learned. One that was never said to begin tells nothing."""
        if job in self.running:
            rule, began = self.running.pop(job)
            self.learn(rule, now - began)

    def learn(self, rule: str, seconds: float) -> None:
        """A job of the rule took so long on this machine."""
        self.times.setdefault(rule, []).append(seconds)

    def pace(self, times: Times) -> float:
        """Seconds here for one second of the table: a weighted geometric mean over rules, 1 at the beginning.

        times: of the jobs of each rule. No rule weighs more than 1: one that has become slower does not speak
        for all.
        """
        logarithms, weights = 0.0, TABLE_RULES
        for rule, seconds in times.items():
            table = len(seconds) * self.table.get(rule, 0.0)
            if table > 0:
                weight = table / (table + TELLING_S)
                logarithms += weight * math.log(max(sum(seconds), 0.01) / table)
                weights += weight
        return math.exp(logarithms / weights)

    def expected(self, rules: Iterable[str], times: Times | None = None) -> dict[str, float]:
        """Seconds of one job of each rule: of the table at this machine's pace, and of its jobs here.

        times: see pace; of the jobs that have ended, unless given.
        """
        times = self.times if times is None else times
        pace = self.pace(times)
        seconds = {}
        for rule in rules:
            here = times.get(rule, [])
            table = TABLE_JOBS * pace * self.table.get(rule, UNKNOWN_S)
            seconds[rule] = (table + sum(here)) / (TABLE_JOBS + len(here))
        return seconds

    def late(self, now: float) -> Times:
        """Times of the jobs that have ended, and of those that run already for longer than expected."""
        expected = self.expected({rule for rule, _ in self.running.values()})
        times = {rule: list(seconds) for rule, seconds in self.times.items()}
        for rule, began in self.running.values():
            at_least = (1 + LATE) * (now - began)
            if at_least > expected[rule]:
                times.setdefault(rule, []).append(at_least)
        return times

    def left(self, needs: Graph, rules: Mapping[Hashable, str], now: float) -> float:
        """Seconds until the last job ends.

        needs: of every job that has not ended, which others must end first; rules: the rule of each.
        """
        expected = self.expected(set(rules.values()), self.late(now))
        seconds = {job: expected[rules[job]] for job in needs}
        running = {job: now - began for job, (_, began) in self.running.items() if job in needs}
        for job, elapsed in running.items():
            seconds[job] = max(seconds[job] - elapsed, LATE * elapsed)
        return makespan(needs, seconds, running, cores=self.cores)


BAR = 20  # letters


def time_words(so_far: float, left: float) -> str:
    """A bar of the time so far in the whole time, and both in minutes; so_far, left: seconds."""
    done = round(BAR * so_far / max(so_far + left, 1e-9))
    minutes = f"about {max(left / 60, 1):.0f} min left, {so_far / 60:.0f} min so far"
    return f"[{'=' * done}{'.' * (BAR - done)}] {minutes}"


def chains(needs: Graph, seconds: Mapping[Hashable, float]) -> dict[Hashable, float]:
    """Seconds of the longest chain of jobs that begins with each job, itself included.

    needs: see Graph; jobs without a line of their own have ended. seconds: of each job.
    """
    after: dict[Hashable, float] = {}
    for job in reversed(order(needs)):
        chain = seconds[job] + after.get(job, 0.0)
        after[job] = chain
        for other in needs[job]:
            after[other] = max(after.get(other, 0.0), chain)
    return {job: after[job] for job in needs}


def order(needs: Graph) -> list[Hashable]:
    """The jobs that have not ended, each behind those that it needs."""
    return [job for job in TopologicalSorter(needs).static_order() if job in needs]


def makespan(
    needs: Graph, seconds: Mapping[Hashable, float], running: Container[Hashable], *, cores: int
) -> float:
    """Seconds until all jobs have ended, when a free core always takes the job with the longest chain.

    needs: see chains; seconds: that each job will still take; running: those that have a core now.
    """
    waits = {job: sum(other in needs for other in others) for job, others in needs.items()}
    follow = followers(needs)
    # Equal jobs are taken in the order in which they were named: jobs themselves need no order.
    ranks = {job: (-chain, i, job) for i, (job, chain) in enumerate(chains(needs, seconds).items())}
    ends = [(seconds[job], i, job) for _, i, job in ranks.values() if job in running]
    ready = [rank for job, rank in ranks.items() if waits[job] == 0 and job not in running]
    heapq.heapify(ends)
    heapq.heapify(ready)
    now = 0.0
    while ready or ends:
        while ready and len(ends) < cores:
            _, i, job = heapq.heappop(ready)
            heapq.heappush(ends, (now + seconds[job], i, job))
        now, _, ended = heapq.heappop(ends)
        for job in follow[ended]:
            waits[job] -= 1
            if waits[job] == 0:
                heapq.heappush(ready, ranks[job])
    return now


def followers(needs: Graph) -> dict[Hashable, list[Hashable]]:
    """Of every job that has not ended, those that wait for it."""
    follow: dict[Hashable, list[Hashable]] = {job: [] for job in needs}
    for job, others in needs.items():
        for other in others:
            if other in needs:
                follow[other].append(job)
    return follow


def stranded(needs: Graph, failed: Container[Hashable]) -> set[Hashable]:
    """The jobs that cannot begin any more, since a job that they need has failed."""
    lost: set[Hashable] = set()
    for job in order(needs):
        if any(other in failed or other in lost for other in needs[job]):
            lost.add(job)
    return lost


def seconds_before(benchmarks: Path) -> dict[str, float]:
    """Mean seconds of a job by rule, of the jobs that ended in this folder before.

    benchmarks: folder of rule/job.tsv as Snakemake writes them, seconds in the first column; may be absent.
    """
    times: Times = {}
    for file in sorted(benchmarks.glob("*/*.tsv")):
        # A file that a killed job left unfinished tells nothing.
        with suppress(IndexError, ValueError):
            times.setdefault(file.parent.name, []).append(float(file.read_text().splitlines()[1].split()[0]))
    return {rule: sum(each) / len(each) for rule, each in times.items()}
