"""Progress of long loops, as log records that a rule's log or a terminal shows."""

import logging
import time
from collections.abc import Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
log = logging.getLogger("mammosim.progress")


def progress(items: Iterable[T], *, label: str, total: int, every_s: float = 2.0) -> Iterator[T]:
    """Yield the items, logging 'label 3/10, 12 s, about 28 s left' at most every `every_s` seconds."""
    start = last = time.monotonic()
    for done, item in enumerate(items, start=1):
        yield item
        now = time.monotonic()
        if now - last >= every_s or done == total:
            left = (now - start) / done * (total - done)
            log.info("%s %d/%d, %.0f s, about %.0f s left", label, done, total, now - start, left)
            last = now
