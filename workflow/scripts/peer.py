"""One program, one mesh, one case: run by its own Python on one thread, within a limit of processor time."""

import json
import os
import resource
import signal
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import _log
import numpy as np
import pandas as pd

from mammosim.io.mesh_arrays import read_mesh_arrays
from mammosim.io.tables import write_table
from mammosim.study.peers import Case, result

ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "MKL", "OPENBLAS", "NUMBA")}
MEASURED = ("load_steps", "newton_iterations", "cpu_s", "memory_mb", "memory_before_mb")


def main(files: dict, job: dict, values: dict, program: dict, out: str) -> None:
    case, mesh = Case.of(values), read_mesh_arrays(files["mesh"])
    if program["missing"]:
        found = {"outcome": f"not installed: {program['missing']}"}
    else:
        found = solved(files, case.facts() | program["settings"], program)
    facts = {name: found.get(name, np.nan) for name in MEASURED}
    row = job | result(case, mesh, found) | facts | {"outcome": found["outcome"]}
    write_table(pd.DataFrame([row]), out)


def solved(files: dict, facts: dict, program: dict) -> dict:
    """What the adapter wrote, or the outcome that its processor time was spent."""
    limit = program["cpu_limit_s"]
    with TemporaryDirectory() as folder:
        case, found = Path(folder) / "case.json", Path(folder) / "found.npz"
        case.write_text(json.dumps(facts))
        command = [program["python"], files["adapter"], files["mesh"], files["coarse"], case, found]
        ended = subprocess.run(
            [*command, *program["arguments"]],
            env=dict(os.environ) | ONE_THREAD,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)),
            check=False,
        )
        if ended.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            return {"outcome": f"stopped after {limit:g} s of processor time"}
        if ended.returncode < 0:
            return {"outcome": f"crashed: signal {-ended.returncode}"}
        ended.check_returncode()
        with np.load(found) as arrays:
            return {name: v if (v := arrays[name]).ndim else v.item() for name in arrays}


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    names = snakemake.wildcards
    job = {"case": names.case, "edge_mm": float(names.edge), "program": names.program}
    main(dict(snakemake.input.items()), job, **snakemake.params, out=snakemake.output[0])
