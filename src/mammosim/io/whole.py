"""Files that are whole: what is packed is unpacked to its end, where its length and checksum stand.

A reader that stops at the last byte it needs never sees them, and gives zeros for what is missing.
"""

import errno
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader, RawIOBase
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from mammosim.core.errors import ImageError

GZIP = b"\x1f\x8b"
AGAIN = "copy it again from where it came, or delete it and run the stage that makes it"
CHUNK = 1 << 20
MOST_PACKED = 1032  # bytes that one byte of gzip can stand for: https://zlib.net/zlib_tech.html


@contextmanager
def unpacked(path: str | Path, *, skip: int = 0, packed: bool | None = None) -> Iterator[BinaryIO]:
    """The bytes of a file behind the first `skip`, without its packing by gzip or zlib.

    packed: whether it is; by itself where its first bytes are those of gzip.
    Raises ImageError, in the block, too: the file ends before its packing does, or its checksum is wrong.
    """
    try:
        with Path(path).open("rb") as file:
            file.seek(skip)
            if packed is None:
                packed = file.peek(len(GZIP)).startswith(GZIP)
            yield BufferedReader(_Unpacked(file), CHUNK) if packed else file
    except EOFError:
        raise ImageError(f"{path} ends early: what was packed is not all there; {AGAIN}") from None
    except zlib.error as error:
        raise ImageError(f"{path} is damaged, its checksum is wrong ({error}); {AGAIN}") from None


class _Unpacked(RawIOBase):
    """Streams of gzip or zlib one after another; zlib compares the checksum and length of each."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.stream, self.left = file, zlib.decompressobj(zlib.MAX_WBITS | 32), b""

    def readable(self) -> bool:
        """Yes."""
        return True

    def readinto(self, room: Any) -> int:
        """How many bytes were put into the room, 0 at the end. Raises EOFError where a stream has no end."""
        while not self.stream.eof or self._another():
            self.left = self.left or self.file.read(CHUNK)
            if not self.left:
                raise EOFError
            part = self.stream.decompress(self.left, len(room))
            self.left = self.stream.unconsumed_tail
            room[: len(part)] = part
            if part:
                return len(part)
        return 0

    def _another(self) -> bool:
        """Whether another stream follows the one that ended; zeros may stand between them."""
        self.left = (self.stream.unused_data + self.file.read(CHUNK)).lstrip(b"\0")
        self.stream = zlib.decompressobj(zlib.MAX_WBITS | 32) if self.left.startswith(GZIP) else self.stream
        return not self.stream.eof


def rest_of(file: BinaryIO) -> int:
    """How many bytes are left; reading them compares the checksum of what is packed."""
    count = 0
    while part := file.read(CHUNK):
        count += len(part)
    return count


def voxels_of(file: BinaryIO, shape: tuple[int, ...], dtype: np.dtype, path: str | Path) -> np.ndarray:
    """The next voxels of a file, shape in C order, and nothing behind them but less than a slice.

    Raises ImageError where fewer or more bytes are there than the header states.
    """
    needed, size = int(np.prod(shape, dtype=float)) * dtype.itemsize, Path(path).stat().st_size
    if needed > MOST_PACKED * size:
        raise ImageError(
            f"{path} ends early: its {size} bytes cannot hold the {needed} bytes of voxels that its header "
            f"states; {AGAIN}"
        )
    values = np.empty(shape, dtype)
    room = values.reshape(-1).view(np.uint8).data
    there = 0
    while part := file.readinto(room[there:]):  # type: ignore[attr-defined]
        there += part
    require_count(path, there + rest_of(file), values.nbytes, slack=values[0].nbytes)
    return values


def require_count(path: str | Path, there: int, needed: int, *, slack: int = 0) -> None:
    """Raise ImageError unless as many bytes of voxels are there as are needed, or up to `slack` more."""
    if there < needed:
        raise ImageError(
            f"{path} ends early: {there} of the {needed} bytes of voxels that its header states are there; "
            f"{AGAIN}"
        )
    if there > needed + slack:
        raise ImageError(
            f"{path} has {there - needed} bytes more than the {needed} bytes of voxels that its header "
            "states; export it again"
        )


def require_written(temporary: Path, path: str | Path, needed: int) -> None:
    """Raise OSError where what another library wrote for `path` is cut short, which that did not say.

    needed: bytes of what is written, unpacked.
    """
    try:
        with unpacked(temporary) as file:
            there = rest_of(file)
    except ImageError:
        there = 0
    if there < needed:
        size = temporary.stat().st_size
        raise OSError(errno.ENOSPC, f"no room: only {size} bytes could be written; free some", str(path))
