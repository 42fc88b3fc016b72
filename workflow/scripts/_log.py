"""Send a script's records, warnings and tracebacks to the log of its rule, and keep to the rule's threads."""

import logging
import os
import sys
import traceback
from types import TracebackType

from mammosim.core.errors import MammosimError


def to(path: str, *, threads: int = 1) -> None:
    """Write everything that is logged from now on to `path`, and errors to the terminal too.

    threads: how many threads compiled kernels may use; results do not depend on it.
    An error of mammosim's own is shown as its message alone; any other one with its traceback.
    """
    logging.basicConfig(
        filename=path, filemode="w", level=logging.INFO, format="%(asctime)s %(name)s %(message)s", force=True
    )
    logging.captureWarnings(True)
    keep_to(threads)

    def report(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        logging.critical("".join(traceback.format_exception(kind, error, trace)))
        if isinstance(error, MammosimError):
            sys.stderr.write(f"\n{kind.__name__}: {error}\n\n")
        else:
            sys.__excepthook__(kind, error, trace)

    sys.excepthook = report


def keep_to(threads: int) -> None:
    """Let compiled kernels use at most so many threads, whether numba is there by now or comes later.

    Many a job needs no kernel: to import numba for it takes longer than what it does.
    """
    if numba := sys.modules.get("numba"):
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
    else:
        given = int(os.environ.get("NUMBA_NUM_THREADS") or threads)
        os.environ["NUMBA_NUM_THREADS"] = str(min(threads, given))
