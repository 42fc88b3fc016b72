"""What a run says at its end when jobs have failed: which, why, where their logs are, and how to go on."""

import re
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

TRACEBACK = "Traceback (most recent call last):"
MISSING_NAMED = 8  # reasons of missing results
NAMED = 5  # failed jobs that are named: with their logs, they fit into the last 20 lines of a terminal
WIDTH = 200  # letters of a reason
NO_LOG = "it has written no log; its error stands further up"
NO_ERROR = "its log ends without an error: it may have been killed, for instance for want of memory"


@dataclass(frozen=True)
class Failure:
    """A job that failed: rule and wildcards, its log if it has one, and what a cluster says of its end."""

    job: str
    log: Path | None
    cluster: str = ""

    def lines(self, since: float) -> list[str]:
        """The job with its reason, and its log; since: when the run began (s since the epoch)."""
        found = self.log is not None and self.log.exists() and self.log.stat().st_mtime >= since
        why = reason(self.log.read_text(errors="replace")) if self.log and found else NO_LOG
        why = self.cluster if self.cluster and why in (NO_ERROR, NO_LOG) else why
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
    why = ", for want of what failed" if known and not stopped else ""
    rest = "What is done" if stopped or not known else "All the rest"
    return "\n".join(
        [
            f"{counted(len(known), 'job')} failed:" if known else "The run was stopped.",
            *named,
            *([f"  and {counted(more, 'other job')}"] if more > 0 else []),
            *([f"Not run{why}: {counted(not_run, 'job')}."] if not_run else []),
            *([f"What this run has said: {run_log}"] if run_log else []),
            f"{rest} is there, in {results}: the same command again does only what is left.",
        ]
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
    last = "Everything else is there; the first page of the report names what follows from these."
    return "\n".join([f"{count_of(reasons)} could not be had:", *lines, *more, last])


def count_of(reasons: Sequence[str]) -> str:
    """How many results are missing, in words."""
    return "One result" if len(reasons) == 1 else f"{len(reasons)} results"
