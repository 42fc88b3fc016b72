"""A batch of points, one after another in one process.

Each is written when it is done, so that no more than one is ever lost, and none is computed twice.
"""

import hashlib
import logging
import shutil
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from mammosim.chain.graph import Chain
from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.chain.quantities import QUANTITIES, Quantity
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError, MammosimError, TableError
from mammosim.io.atomic import replacing
from mammosim.io.tables import read_json, write_json

log = logging.getLogger(__name__)
REJECTED = "rejected"
Row = dict[str, Any]


@dataclass(frozen=True)
class Item:
    """A point as a job has it, see points.Planned. stored: product -> digest, of what it shares."""

    name: str
    shown: Mapping[str, Any]
    changes: Mapping[str, Any]
    effects: Sequence[str] | None
    kept: Mapping[str, Mapping[str, str]]
    own: Mapping[str, str]
    stored: Mapping[str, str]
    rejected: str = ""


@dataclass(frozen=True)
class Batch:
    """chain: of the breast, before anything varies; read: the products that answers are taken from.

    points, products: the folders of finished points and of what points share; library: product -> digest of
    the code that it depends on.
    """

    chain: Chain
    read: Sequence[str]
    points: Path
    products: Path
    library: Mapping[str, str]
    contents: dict[str, str] = field(default_factory=dict)

    def rows(self, items: Sequence[Item]) -> Iterator[Row]:
        """A row per point: its name, answers, errors, outcome, reason, processor seconds and what took them.

        Raises RuntimeError at the end where the program itself failed in a point: the others are done.
        """
        faults: list[str] = []
        for n, item in enumerate(items):
            later = {pair for other in items[n + 1 :] for pair in other.own.items()}
            row = self._rejected(item) or self._finished(item)
            if row is None:
                try:
                    row = self._computed(item, later)
                except Exception as error:
                    log.exception("point %s", item.name)
                    faults.append(f"point {item.name} ({item.shown}): {type(error).__name__}: {error}")
                    continue
                self.file(item).parent.mkdir(parents=True, exist_ok=True)
                write_json(row, self.file(item))
            yield {"point": item.name, "shown": dict(item.shown), **row}
        if faults:
            raise RuntimeError(
                f"{len(faults)} points ended in a fault of the program, the first: {faults[0]}"
            )

    def file(self, item: Item) -> Path:
        """Where a point is kept."""
        return self.points / item.name[:2] / f"{item.name}.json"

    def _rejected(self, item: Item) -> Row | None:
        if not item.rejected:
            return None
        return _row(outcome=REJECTED, reason=item.rejected)

    def _finished(self, item: Item) -> Row | None:
        """What was computed before, of the same inputs; None where it was not, or is damaged."""
        try:
            row: Row = read_json(self.file(item))
        except (FileNotFoundError, TableError):
            return None
        return row if row.get("inputs") == self._inputs(item) else None

    def _inputs(self, item: Item) -> str:
        """A digest of the content of what is read of the study."""
        paths = sorted(path for files in item.kept.values() for path in files.values())
        return hashlib.sha256("".join(map(self._content, paths)).encode()).hexdigest()[:16]

    def _content(self, path: str) -> str:
        if path not in self.contents:
            with Path(path).open("rb") as file:
                self.contents[path] = hashlib.file_digest(file, "sha256").hexdigest()
        return self.contents[path]

    def _computed(self, item: Item, later: set[tuple[str, str]]) -> Row:
        began, inputs = time.process_time(), self._inputs(item)
        before = set(self.chain.made)
        chain = self.chain.with_settings(item.changes) if item.changes else self.chain
        chain = chain if item.effects is None else chain.with_effects(item.effects)
        chain, took = self._shared(chain.kept(item.kept), item, inputs)
        answered = {
            name: each for name, each in QUANTITIES.items() if {*each.products, *each.beside} <= {*self.read}
        }
        try:
            answers, errors = _answers(chain, answered)
            row = _row(answers, errors)
        except MammosimError as error:
            row = _row(None, None, *_outcome(error))
        new = {name: key for name, key in chain.keys.items() if key in chain.made and key not in before}
        took |= {name: chain.made[key].seconds for name, key in new.items() if chain.made[key].seconds > 0}
        for name, key in chain.keys.items():
            # What no later point is made of need not be held.
            if name in item.own and (name, item.own[name]) not in later:
                chain.made.pop(key, None)
        return row | {"seconds": time.process_time() - began, "took": took, "inputs": inputs}

    def _shared(self, chain: Chain, item: Item, inputs: str) -> tuple[Chain, dict[str, float]]:
        """The chain with what its point shares with others, made where it is not there yet, and its seconds.

        It is read by all of them, by the first, too, so that a point does not depend on who came first.
        """
        took: dict[str, float] = {}
        for name, digest in item.stored.items():
            files = self._files(name, digest, inputs)
            if not are_there(files):
                if chain.make(name).failure is not None:
                    continue  # its point says why
                took[name] = self._save(chain, name, files)
            chain = chain.kept({name: files})
        return chain, took

    def _files(self, name: str, digest: str, inputs: str) -> dict[str, str]:
        kept = STAGES[name].files
        endings = {**kept.endings, **kept.beside} if kept else {}
        called = hashlib.sha256(f"{digest} {self.library[name]} {inputs}".encode()).hexdigest()[:16]
        folder = self.products / name / called
        return {file: str(folder / f"{file}{ending}") for file, ending in endings.items()}

    def _save(self, chain: Chain, name: str, files: Mapping[str, str]) -> float:
        folder = Path(next(iter(files.values()))).parent
        folder.parent.mkdir(parents=True, exist_ok=True)
        if folder.is_dir() and not are_there(files):
            shutil.rmtree(folder)
        # Another batch may have made it meanwhile, and be reading it.
        with replacing(folder, keep=True) as temporary:
            temporary.mkdir()
            paths = {file: str(temporary / Path(path).name) for file, path in files.items()}
            STAGES[name].save(chain[name], paths, {"side": chain.subject.side})
        seconds = chain.made.pop(chain.key(name)).seconds
        log.info("%s is shared and kept: %.1f s", name, seconds)
        return seconds


def are_there(files: Mapping[str, str]) -> bool:
    """Whether all of these files are there."""
    return all(Path(path).exists() for path in files.values())


def _answers(
    chain: Chain, answered: Mapping[str, Quantity]
) -> tuple[dict[str, float | None], dict[str, float | None]]:
    """Every value, three of a place, and its standard error where it has one; None for no finite number."""
    values: dict[str, float | None] = {}
    errors: dict[str, float | None] = {}
    for name, quantity in answered.items():
        column = quantity.column or name
        found = np.atleast_1d(np.asarray(quantity.of(chain), float))
        values |= dict(zip(columns(column, len(found)), map(_finite, found)))
        if quantity.noise is not None:
            errors[column] = _finite(abs(found[0]) * quantity.noise(chain))
    return values, errors


def columns(column: str, size: int) -> tuple[str, ...]:
    """'nipple_x_mm', 'nipple_y_mm' and 'nipple_z_mm' of a place, else the name itself."""
    if size == 1:
        return (column,)
    name, _, unit = column.rpartition("_")
    return tuple(f"{name}_{axis}_{unit}" for axis in "xyz"[:size])


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _row(
    answers: Mapping[str, float | None] | None = None,
    errors: Mapping[str, float | None] | None = None,
    outcome: str = CONVERGED,
    reason: str = "",
) -> Row:
    none = ", ".join(name for name, value in (answers or {}).items() if value is None)
    why = reason or (f"no finite number: {none}" if none else "")
    return {
        "answers": dict(answers or {}), "errors": dict(errors or {}), "outcome": outcome, "reason": why,
        "seconds": 0.0, "took": {},
    }  # fmt: skip


def _outcome(error: MammosimError) -> tuple[str, str]:
    reason = " ".join(str(error).split())
    if isinstance(error, ConfigurationError):
        return REJECTED, reason
    return unsolved(error).split(":")[0], reason


def items(points: Iterable[Mapping[str, Any]], kept: Sequence[Mapping[str, Mapping[str, str]]]) -> list[Item]:
    """The points of a job from its parameters, where each names what it reads by its number."""
    return [Item(**{**point, "kept": kept[point["kept"]]}) for point in points]
