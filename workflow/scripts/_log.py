"""Send a script's records, warnings and tracebacks to the log of its rule, and keep to the rule's threads.

A script ends with the run that has started it, however that ends: else it would go on writing what the next
run makes, too.
"""

import ctypes
import logging
import os
import signal
import sys
import traceback
from pathlib import Path
from types import TracebackType

from mammosim.core.errors import MammosimError

PR_SET_PDEATHSIG = 1  # linux/prctl.h
ORPHANS_PARENT = 1  # where a container is made for one run, the run itself


def end_with_the_run() -> None:
    """End at once when the run is killed, and without a traceback when a person ends it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if not sys.platform.startswith("linux"):
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    first = Path(f"/proc/{ORPHANS_PARENT}/cmdline")
    if os.getppid() == ORPHANS_PARENT and b"snakemake" not in first.read_bytes():
        sys.exit("the run that has started this job has ended")


def to(path: str, *, threads: int = 1) -> None:
    """Write everything that is logged from now on to `path`, and errors to the terminal too.

    threads: how many threads compiled kernels may use; results do not depend on it.
    An error of mammosim's own is shown as its message alone; any other one with its traceback.
    """
    end_with_the_run()
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
