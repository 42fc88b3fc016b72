"""Send a script's records, warnings and tracebacks to the log of its rule."""

import logging
import sys
import traceback
from types import TracebackType

from mammosim.core.errors import MammosimError


def to(path: str) -> None:
    """Write everything that is logged from now on to `path`, and errors to the terminal too.

    A refusal of mammosim's own is shown as its message alone; anything else with its traceback.
    """
    logging.basicConfig(
        filename=path, filemode="w", level=logging.INFO, format="%(asctime)s %(name)s %(message)s", force=True
    )
    logging.captureWarnings(True)

    def report(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        logging.critical("".join(traceback.format_exception(kind, error, trace)))
        if isinstance(error, MammosimError):
            sys.stderr.write(f"\n{kind.__name__}: {error}\n\n")
        else:
            sys.__excepthook__(kind, error, trace)

    sys.excepthook = report
