"""Whose breast a chain is about, and what its random streams are called."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Subject:
    """One breast, measured in one position.

    side: left or right; gravity: its direction 'x y z' in the scanner frame of that position; streams: names
    of the random streams of photons and noise, scan: of those of the images, each beginning with the study's
    seed. moves: whether that position is moved into the frame of another one, the reference. has: what is
    given of that position, see chain.allowed.Data; 'reference' where positions are brought into one frame.
    """

    side: str
    gravity: str
    streams: tuple[str | int, ...]
    scan: tuple[str | int, ...] = ()
    moves: bool = True
    has: tuple[str, ...] = ("images", "strokes", "fiducials", "reference")

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> "Subject":
        """Of plain values, where streams may be lists."""
        tuples = {name: tuple(values[name]) for name in ("streams", "scan", "has") if name in values}
        return cls(**{**values, **tuples})

    def repeated(self, repeat: int) -> "Subject":
        """With random streams of its own for each repeat; the first has those of the study."""
        if repeat == 0:
            return self
        more = ("repeat", repeat)
        return replace(self, streams=(*self.streams, *more), scan=(*self.scan, *more))
