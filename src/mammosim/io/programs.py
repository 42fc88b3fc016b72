"""Problems as plain files, and programs of others that solve them: each by its own Python, on one thread.

A program has a limit of processor time.
"""

import json
import os
import resource
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from mammosim.io.atomic import replacing


def write_problem(arrays: Mapping[str, np.ndarray], facts: Mapping[str, Any], path: str | Path) -> None:
    """Write the arrays by name, and beside them `facts`: nested plain values as JSON."""
    with replacing(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, allow_pickle=False, facts=np.array(json.dumps(facts)), **arrays)


ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "MKL", "OPENBLAS", "NUMBA")}
ONE_THREAD["ITK_GLOBAL_DEFAULT_NUMBER_OF_THREADS"] = "1"


def found_by(
    command: Sequence[str], facts: Mapping[str, Any], *, cpu_limit_s: int, arguments: Sequence[str] = ()
) -> dict[str, Any]:
    """What a program found, by name: arrays, and numbers and words as such; its own fate under `outcome`.

    command: a Python, an adapter and the files that it reads. The adapter is given two more names, of the
    facts (.json) and of what it is to write (.npz), and then the arguments.
    Raises subprocess.CalledProcessError when it ended with an error.
    """
    with TemporaryDirectory() as folder:
        case, found = Path(folder) / "case.json", Path(folder) / "found.npz"
        case.write_text(json.dumps(facts))
        ended = subprocess.run(
            [*command, str(case), str(found), *arguments],
            env=dict(os.environ) | ONE_THREAD,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (cpu_limit_s, cpu_limit_s)),
            check=False,
        )
        if ended.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            return {"outcome": f"stopped after {cpu_limit_s:g} s of processor time"}
        if ended.returncode < 0:
            return {"outcome": f"crashed: signal {-ended.returncode}"}
        ended.check_returncode()
        with np.load(found) as arrays:
            return {name: v if (v := arrays[name]).ndim else v.item() for name in arrays}
