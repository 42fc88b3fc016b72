"""What a run says at its end when jobs have failed: which, why, where their logs are, and how to go on."""

import os
import re
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from mammosim.io.atomic import is_alive, machine

TRACEBACK = "Traceback (most recent call last):"
MISSING_NAMED = 8  # reasons of missing results
NAMED = 5  # failed jobs that are named: with their logs, they fit into the last 20 lines of a terminal
WIDTH = 200  # letters of a reason
NO_LOG = "it has written no log; its error is further up"
NO_ERROR = "its log ends without an error: it may have been killed, for instance because memory ran out"
NO_MEMORY = "MemoryError"
# Where a run says whose lock it has, and since when it is at work.
LOCKED_BY = Path(".snakemake/mammosim_run")


@dataclass(frozen=True)
class Failure:
    """A job that failed: rule and wildcards, its log if it has one, its memory, what a cluster says of it."""

    job: str
    log: Path | None
    mem_mb: int | None = None
    cluster: str = ""

    def lines(self, since: float) -> list[str]:
        """The job with its reason, and its log; since: when the run began (s since the epoch)."""
        found = self.log is not None and self.log.exists() and self.log.stat().st_mtime >= since
        why = reason(self.log.read_text(errors="replace")) if self.log and found else NO_LOG
        why = self.cluster if self.cluster and why in (NO_ERROR, NO_LOG) else why
        if self.mem_mb and not self.cluster and (why == NO_ERROR or why.startswith(NO_MEMORY)):
            why = f"{why}; it asks for {self.mem_mb} MB (mem_mb), fewer jobs at once leave more for each"
        return [f"  {self.job}: {why}", *([f"    log: {self.log}"] if found else [])]


def reason(log: str) -> str:
    """The error that a log ends with, as 'Name: first line of its message'."""
    _, traceback, rest = log.rpartition(TRACEBACK)
    if not traceback:
        return NO_ERROR
    # Lines of the traceback are indented; what was raised is not.
    raised = next((line for line in rest.splitlines() if re.match(r"\w", line)), NO_ERROR)
    return re.sub(r"^(\w+\.)+(?=\w+(:|$))", "", raised)[:WIDTH]


def last_words(
    failures: Iterable[Failure],
    *,
    not_run: int,
    stopped: bool,
    results: Path,
    run_log: Path | None,
    since: float,
) -> str:
    """At most 15 lines about a run that did not reach its end.

    not_run: jobs that were not run, since they need what failed, or since the run was stopped, as it is where
    an input is rejected; results: the folder of what is there; run_log: what Snakemake has
    said; since: see Failure.lines.
    """
    known = sorted(failures, key=lambda failure: failure.job)
    named = [line for failure in known[:NAMED] for line in failure.lines(since)]
    more = len(known) - NAMED
    why = ", since they need what failed" if known and not stopped else ""
    rest = "Finished results" if stopped or not known else "All the remaining results"
    return "\n".join(
        [
            f"{counted(len(known), 'job')} failed:" if known else "The run was stopped.",
            *named,
            *([f"  and {counted(more, 'other job')}"] if more > 0 else []),
            *([f"Not run{why}: {counted(not_run, 'job')}."] if not_run else []),
            *([f"Output of this run: {run_log}"] if run_log else []),
            f"{rest} are in {results}: the same command computes only what is left.",
        ]
    )


@dataclass(frozen=True)
class Run:
    """The process of a run, and the machine that it runs on."""

    process: int
    machine: str

    @classmethod
    def here(cls) -> "Run":
        """This process."""
        return cls(os.getpid(), machine())

    @classmethod
    def read(cls, file: Path) -> "Run | None":
        """Of what a run has written; None where nothing can be read."""
        try:
            process, name = file.read_text(encoding="utf-8").split()
            return cls(int(process), name)
        except (OSError, ValueError):
            return None

    @classmethod
    def began(cls, file: Path) -> str:
        """What tells the run that is at work from others: process, machine and beginning; '' of none."""
        run = cls.read(file)
        return f"{run.process} {run.machine} {file.stat().st_mtime_ns}" if run and run.goes_on else ""

    def write(self, file: Path) -> None:
        """For the next run."""
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{self.process} {self.machine}\n", encoding="utf-8")

    @property
    def goes_on(self) -> bool:
        """Whether the process is there, as far as can be seen: on another machine it may be."""
        return self.machine != machine() or is_alive(self.process)


def interrupted(*, left: int, results: Path, run_log: Path | None) -> str:
    """Three lines about a run that a person has ended; left: jobs that were not done."""
    return "\n".join(
        [
            f"Stopped as you asked; {counted(left, 'job')} left, including those that were running.",
            f"Output of this run: {run_log or 'none'}",
            f"Finished results are in {results}: the same command computes only what is left.",
        ]
    )


def locked(lock: Run | None, folder: Path) -> str:
    """In one line why a run cannot begin where another one has left its lock, and what to do."""
    if lock is not None and lock.goes_on:
        return (
            f"another run, process {lock.process}, is at work in {folder}: let it end, or use --directory "
            "elsewhere; if that process is something else, use --unlock first"
        )
    return (
        f"a run in {folder} was killed and has left its lock; if no other run is at work there, "
        "the same command with --unlock removes it, and without --unlock continues the run"
    )


def counted(number: int, noun: str) -> str:
    """'1 job', '2 jobs'."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def missing_in_brief(reasons: Sequence[str]) -> str:
    """What a terminal ends with where results are missing: the first reasons, a line each; else nothing."""
    if not reasons:
        return ""
    lines = [f"  {textwrap.shorten(reason, WIDTH)}" for reason in reasons[:MISSING_NAMED]]
    more = [f"  and {len(reasons) - MISSING_NAMED} more"] if len(reasons) > MISSING_NAMED else []
    last = "Everything else is computed; the first page of the report names what is missing as a consequence."
    return "\n".join([f"{count_of(reasons)} could not be computed:", *lines, *more, last])


def count_of(reasons: Sequence[str]) -> str:
    """How many results are missing, in words."""
    return "One result" if len(reasons) == 1 else f"{len(reasons)} results"
