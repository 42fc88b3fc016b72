"""Send a script's records, warnings and tracebacks to the log of its rule, and keep to the rule's threads.

A script ends with the run that has started it, however that ends: else it would go on writing what the next
run makes, too.
"""

import ctypes
import logging
import os
import signal
import sys
import threading
import time
import traceback
from types import TracebackType

from mammosim.core.errors import MammosimError
from mammosim.io.atomic import is_alive

PR_SET_PDEATHSIG = 1  # linux/prctl.h
RUN = "MAMMOSIM_RUN"  # the process of the run, as common.smk hands it on; none for a script started by hand
LOOK_S = 1.0


def end_with_the_run() -> None:
    """End when the run is killed, and without a traceback when a person ends it.

    The system tells of the death of whatever has started this script: the run, where the shell that the run
    starts gives its place to the script. Not every shell does, so that a thread looks for the run itself.
    Ctrl-C is left to the run, which ends its jobs: one that ends by itself before the run knows is a failure.
    """
    run = os.environ.get(RUN, "")
    if not run.isdecimal():
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if not is_alive(int(run)):
        sys.exit("the run that has started this job has ended")
    threading.Thread(target=end_behind, args=(int(run),), daemon=True).start()


def end_behind(run: int) -> None:
    """Kill this process as soon as another one has ended."""
    while is_alive(run):
        time.sleep(LOOK_S)
    os.kill(os.getpid(), signal.SIGKILL)


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
