"""Compiled kernels: numba's njit, whose cache is a help and never a reason to stop.

Kernels are cached where numba puts them: beside their source, however a run starts, or in NUMBA_CACHE_DIR.
A cache that cannot be read is left aside, and one that cannot be written is done without.
"""

import logging
from collections.abc import Callable
from typing import Any, TypeVar, overload

import numba
from numba import prange
from numba.core.caching import IndexDataCacheFile

__all__ = ["njit", "prange"]
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
