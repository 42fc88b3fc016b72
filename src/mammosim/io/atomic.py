"""Files that are either complete or absent, so that unfinished output is never mistaken for finished."""

import hashlib
import os
import platform
import shutil
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

UNFINISHED = ".unfinished-"
# ASSUME: what is still being written changes within the hour.
IDLE_S = 3600.0
ENDED = (b"Z", b"X")  # states of a process that has ended, in /proc


@contextmanager
def replacing(path: str | Path, *, keep: bool = False) -> Iterator[Path]:
    """Yield a temporary path beside `path`, with the same suffixes; rename it to `path` on success.

    Write a file or make a folder there. When the block raises, what was written is removed and an
    earlier `path` stays as it was. What was written is on the disk before it has its name: where that has no
    room, OSError names `path`. What a killed job left of the same `path` is removed. keep: of a folder that
    several write at once the first one stays, since it may be being read by now.
    """
    path = Path(path)
    _remove_abandoned(path)
    writer = f"{machine()}-{os.getpid()}-{uuid.uuid4().hex[:8]}"
    temporary = path.with_name(f".{path.name}{UNFINISHED}{writer}{''.join(path.suffixes)}")
    try:
        yield temporary
        _flush(temporary)
        if path.is_dir() and not keep:
            shutil.rmtree(path)
        _place(temporary, path, keep=keep)
    except OSError as error:
        if error.filename in (None, str(temporary)) and error.errno is not None:
            raise OSError(error.errno, f"{error.strerror}; nothing was written", str(path)) from error
        raise
    finally:
        _remove(temporary)


def _place(temporary: Path, path: Path, *, keep: bool) -> None:
    try:
        temporary.replace(path)
    except OSError:
        # No folder takes the place of one that holds anything.
        if not (keep and path.is_dir()):
            raise


def machine() -> str:
    """Eight digits of what tells apart two processes of one number: the machine and the container."""
    space = Path("/proc/self/ns/pid")
    name = platform.node() + (os.readlink(space) if space.is_symlink() else "")
    return hashlib.sha256(name.encode()).hexdigest()[:8]


def _flush(temporary: Path) -> None:
    """Onto the disk: only then has a disk, or a server of files, said that it has room."""
    for file in [temporary, *temporary.rglob("*")]:
        if file.is_file():
            with file.open("rb") as written:
                os.fsync(written.fileno())


def _remove_abandoned(path: Path) -> None:
    start = f".{path.name}{UNFINISHED}"
    for name in os.listdir(path.parent) if path.parent.is_dir() else ():
        if name.startswith(start) and _is_abandoned(path.with_name(name), name.removeprefix(start)):
            _remove(path.with_name(name))


def _is_abandoned(temporary: Path, writer: str) -> bool:
    """Whether its process has ended, or, where that cannot be seen, it has not changed for IDLE_S."""
    where, process, *_ = writer.split("-")
    if where == machine() and process.isdecimal() and not is_alive(int(process)):
        return True
    try:
        return time.time() - temporary.stat().st_mtime > IDLE_S
    except FileNotFoundError:
        return False


def is_alive(process: int) -> bool:
    """Whether a process of that number runs on this machine; one that has ended may still have its number."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    try:
        state = Path(f"/proc/{process}/stat").read_bytes()
    except OSError:
        return True
    return state.rpartition(b")")[2].split()[0] not in ENDED


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
