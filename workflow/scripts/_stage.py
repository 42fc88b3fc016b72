"""Run the script of a rule that may find no answer: its outputs then say so, and the other jobs go on.

What mammosim itself rejects or cannot solve for one woman, side, strategy or view is an outcome of the study.
A setting that cannot be meant, a damaged file, and any other exception, is a fault: it fails the job.
"""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import _log

from mammosim.core.errors import ConfigurationError, DamagedFile, MammosimError, MissingResult
from mammosim.io.missing import write_missing

# The column of a table for each wildcard of a rule that has another name there.
COLUMNS = {
    **{"v": "volunteer", "w": "volunteer", "p": "position"},
    **{"kpa": "youngs_modulus_kpa", "published": "model"},
}


@contextmanager
def run(snakemake) -> Iterator[dict[str, str]]:
    """The columns that tell the rows of a job's tables apart, with their values.

    Records go to the rule's log; where the block finds no answer, every output says why.
    """
    _log.to(snakemake.log[0], threads=snakemake.threads)
    names = {name: value for name, value in snakemake.wildcards.items() if name != "also"}
    job = {COLUMNS.get(name, name): value for name, value in names.items()}
    try:
        yield job
    except (ConfigurationError, DamagedFile):
        raise
    except MammosimError as error:
        reason = " ".join(str(error).split())
        if not isinstance(error, MissingResult):
            logging.error("no answer", exc_info=error)
            reason = f"{' '.join([snakemake.rule, *job.values()])}: {reason}"
            sys.stderr.write(f"\nno result here; all other jobs continue: {reason}\n\n")
        for path in snakemake.output:
            write_in_place(path, reason, job)


def settings(snakemake) -> dict[str, Any]:
    """What a rule gives its script, without the digests of the code that it depends on."""
    return {name: value for name, value in snakemake.params.items() if name not in ("library", "solver")}


def write_in_place(path: str, reason: str, job: dict[str, str]) -> None:
    """The reason in the place of one output."""
    if Path(path).suffix == ".pdf":
        return  # beside its PNG
    if Path(path).suffix == ".png":
        # By name: a job that makes no picture does not depend on what draws and writes them.
        notice = import_module("mammosim.figures.status").notice
        import_module("mammosim.io.figures").write_figure(notice(reason), path, missing=reason)
    else:
        write_missing(path, reason, job=job)
