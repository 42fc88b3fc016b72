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

from mammosim.chain.graph import Chain, Made
from mammosim.chain.stages import STAGES
from mammosim.core.errors import TableError
from mammosim.io.atomic import replacing
from mammosim.io.tables import read_json, write_json
from mammosim.study.campaigns.answers import REJECTED, Row, answered, faulty, row_of
from mammosim.study.campaigns.failures import Failures, ProgramFault

log = logging.getLogger(__name__)


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
    the code that it depends on; failures: of what points share, in this run.
    """

    chain: Chain
    read: Sequence[str]
    points: Path
    products: Path
    library: Mapping[str, str]
    failures: Failures = field(default_factory=Failures)
    contents: dict[str, str] = field(default_factory=dict)

    def rows(self, items: Sequence[Item]) -> Iterator[Row]:
        """A row per point: its name, what is shown, and a row of `answers`.

        A point in which the program itself fails has a row, too, see `answers.faults`, and is not kept: it is
        computed again. Raises OSError where the machine fails, as a disk without room does, at all alike.
        """
        for n, item in enumerate(items):
            later = {pair for other in items[n + 1 :] for pair in other.own.items()}
            row = self._rejected(item) or self._finished(item) or self._tried(item, later)
            yield {"point": item.name, "shown": dict(item.shown), **row}

    def file(self, item: Item) -> Path:
        """Where a point is kept."""
        return self.points / item.name[:2] / f"{item.name}.json"

    def _rejected(self, item: Item) -> Row | None:
        if not item.rejected:
            return None
        return row_of(outcome=REJECTED, reason=item.rejected)

    def _finished(self, item: Item) -> Row | None:
        """What was computed before, of the same inputs; None where it was not, or is damaged."""
        try:
            row: Row = read_json(self.file(item))
        except (FileNotFoundError, TableError):
            return None
        return row if row.get("inputs") == self._inputs(item) else None

    def _tried(self, item: Item, later: set[tuple[str, str]]) -> Row:
        """Computed and kept; where the program fails, only told."""
        try:
            row = self._computed(item, later)
        except OSError:
            raise
        except Exception as error:
            log.exception("point %s", item.name)
            return faulty(error)
        self.file(item).parent.mkdir(parents=True, exist_ok=True)
        write_json(row, self.file(item))
        return row

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
        chain = self._varied(item)
        try:
            chain, took = self._shared(chain, item, inputs)
            row = answered(chain, self.read)
            new = {name: key for name, key in chain.keys.items() if key in chain.made and key not in before}
            took |= {
                name: chain.made[key].seconds for name, key in new.items() if chain.made[key].seconds > 0
            }
        finally:
            for name, digest in item.own.items():
                # What no later point is made of need not be held.
                if (name, digest) not in later:
                    chain.made.pop(chain.key(name), None)
        return row | {"seconds": time.process_time() - began, "took": took, "inputs": inputs}

    def _varied(self, item: Item) -> Chain:
        chain = self.chain.with_settings(item.changes) if item.changes else self.chain
        chain = chain if item.effects is None else chain.with_effects(item.effects)
        return chain.kept(item.kept)

    def _shared(self, chain: Chain, item: Item, inputs: str) -> tuple[Chain, dict[str, float]]:
        """The chain with what its point shares with others, made where it is not there yet, and its seconds.

        It is read by all of them, by the first, too, so that a point does not depend on who came first.
        """
        took: dict[str, float] = {}
        for name, digest in item.stored.items():
            place = self._place(name, digest, inputs)
            files = _files(name, place)
            if not are_there(files):
                if self._fails(chain, name, place):
                    continue  # its point says why
                took[name] = self._save(chain, name, files)
            chain = chain.kept({name: files})
        return chain, took

    def _fails(self, chain: Chain, name: str, place: Path) -> bool:
        """Whether what is shared has no answer, which is tried once in a run; else it is made.

        Raises ProgramFault, or what it is, where the program fails at it.
        """
        known = self.failures.known(place)
        if isinstance(known, ProgramFault):
            raise known
        if known is not None:
            chain.made[chain.key(name)] = Made(None, known, 0.0)
            return True
        try:
            failure: Exception | None = chain.make(name).failure
        except (OSError, MemoryError):  # what another batch may have room for
            raise
        except Exception as error:
            self.failures.keep(error, place)
            raise
        if failure is not None:
            self.failures.keep(failure, place)
        return failure is not None

    def _place(self, name: str, digest: str, inputs: str) -> Path:
        """The folder of what is shared."""
        called = hashlib.sha256(f"{digest} {self.library[name]} {inputs}".encode()).hexdigest()[:16]
        return self.products / name / called

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


def _files(name: str, place: Path) -> dict[str, str]:
    kept = STAGES[name].files
    endings = {**kept.endings, **kept.beside} if kept else {}
    return {file: str(place / f"{file}{ending}") for file, ending in endings.items()}


def are_there(files: Mapping[str, str]) -> bool:
    """Whether all of these files are there."""
    return all(Path(path).exists() for path in files.values())


def items(points: Iterable[Mapping[str, Any]], kept: Sequence[Mapping[str, Mapping[str, str]]]) -> list[Item]:
    """The points of a job from its parameters, where each names what it reads by its number."""
    return [Item(**{**point, "kept": kept[point["kept"]]}) for point in points]
