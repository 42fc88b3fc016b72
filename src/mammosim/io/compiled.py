"""Compiled kernels: numba's njit, whose cache is a help and never a reason to stop.

Kernels are cached where numba puts them: beside their source, however a run starts, or in NUMBA_CACHE_DIR.
A cache that cannot be read is left aside, and one that cannot be written is done without. Of processes that
start together and lack the same kernel one compiles it, and the others read what it kept.
"""

import fcntl
import logging
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar, overload

import numba
from numba import prange
from numba.core.caching import IndexDataCacheFile
from numba.core.dispatcher import Dispatcher

__all__ = ["njit", "prange"]
# How long a process waits for a kernel that another one compiles, and how often it looks.
WAIT_S, LOOK_S = 120.0, 0.05
log = logging.getLogger(__name__)
Kernel = TypeVar("Kernel", bound=Callable[..., Any])


@overload
def njit(function: Kernel, /) -> Kernel: ...
@overload
def njit(**options: Any) -> Callable[[Kernel], Kernel]: ...
def njit(*function: Callable[..., Any], **options: Any) -> Any:
    """numba.njit; without its cache where there is no place for one."""

    def compiled(kernel: Callable[..., Any]) -> Any:
        try:
            return numba.njit(**options)(kernel)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            log.info("compiled anew in every process: %s", error)
            return numba.njit(**{**options, "cache": False})(kernel)

    return compiled(*function) if function else compiled


def _forgiving(name: str, otherwise: Any) -> None:
    """Let a method of numba's cache files give `otherwise` where a file is damaged or cannot be written."""
    original = getattr(IndexDataCacheFile, name)

    def method(self: IndexDataCacheFile, *args: Any) -> Any:
        try:
            return original(self, *args)
        except Exception as error:  # a pickle that was cut off raises almost anything
            log.info("the cache of compiled kernels is left aside: %s: %s", type(error).__name__, error)
            return dict(otherwise) if isinstance(otherwise, dict) else otherwise

    setattr(IndexDataCacheFile, name, method)


_forgiving("_load_index", {})
_forgiving("load", None)
_forgiving("save", None)


_compiling: set[str] = set()  # indices of the cache that this process has locked


def _locked(file: str) -> int | None:
    """A lock, to be closed; None where there is no place for one, or another process held it for long."""
    try:
        os.makedirs(os.path.dirname(file), exist_ok=True)
        lock = os.open(file, os.O_CREAT | os.O_RDWR, 0o666)
    except OSError:
        return None
    until = time.monotonic() + WAIT_S
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return lock
        except BlockingIOError:
            if time.monotonic() > until:
                break
            time.sleep(LOOK_S)
        except OSError:  # a disk without locks
            break
    os.close(lock)
    return None


@contextmanager
def _alone(index: str) -> Iterator[None]:
    """No other process compiles the kernel of this index of the cache meanwhile."""
    lock = None if index in _compiling else _locked(f"{index}.lock")
    if lock is None:
        yield
        return
    _compiling.add(index)
    try:
        yield
    finally:
        _compiling.discard(index)
        os.close(lock)


_compile = Dispatcher.compile


def _compile_once(self: Any, signature: Any) -> Any:
    """Dispatcher.compile, which looks into the cache first."""
    file = getattr(self._cache, "_cache_file", None)
    if file is None:
        return _compile(self, signature)
    with _alone(file._index_path):
        return _compile(self, signature)


Dispatcher.compile = _compile_once  # type: ignore[method-assign, assignment]
