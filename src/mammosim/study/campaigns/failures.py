"""Failures of what points share: each is kept, so that a run tries it once, and not in every batch."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mammosim.core import errors
from mammosim.core.errors import EquilibriumError, MammosimError, TableError
from mammosim.io.tables import read_json, write_json


class ProgramFault(Exception):
    """The program itself failed at what points share, in this run: 'Name of the exception: message'."""


@dataclass(frozen=True)
class Failures:
    """Those of one run; another one, which a person has started, tries again.

    run: what tells a run from others, '' where that is not known and nothing is kept.
    """

    run: str = ""

    def keep(self, error: Exception, place: Path) -> None:
        """For the other batches of the run. place: of what failed, by its inputs, settings and code."""
        if self.run:
            place.parent.mkdir(parents=True, exist_ok=True)
            write_json({"run": self.run} | _told(error), _file(place))

    def known(self, place: Path) -> MammosimError | ProgramFault | None:
        """How it failed in this run, as the same kind of error; None where it did not."""
        try:
            told: dict[str, Any] = read_json(_file(place))
        except TableError:  # it is not there
            return None
        return _again(told) if self.run and told["run"] == self.run else None


def _file(place: Path) -> Path:
    return place.with_name(f"{place.name}_failure.json")


def _told(error: Exception) -> dict[str, Any]:
    """An error in plain values: what else an equilibrium error has decides what is tried next."""
    told: dict[str, Any] = {"kind": type(error).__name__, "message": str(error)}
    if isinstance(error, EquilibriumError):
        told |= {"load_factor": error.load_factor, "unstable": error.mode is not None}
    return told


def _again(told: dict[str, Any]) -> MammosimError | ProgramFault:
    kind, message = getattr(errors, told["kind"], None), told["message"]
    if not (isinstance(kind, type) and issubclass(kind, MammosimError)):
        return ProgramFault(f"{told['kind']}: {message}")
    if issubclass(kind, EquilibriumError):
        mode = np.zeros((0, 3)) if told["unstable"] else None
        return kind(message, load_factor=told["load_factor"], mode=mode)
    return kind(message)
