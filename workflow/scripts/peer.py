"""One program, one mesh, one case: run by its own Python on one thread, within a limit of processor time."""

import _log
import _stage
import numpy as np
import pandas as pd

from mammosim.io.meshes import read_mesh_arrays
from mammosim.io.programs import found_by
from mammosim.io.tables import write_table
from mammosim.study.peers.mechanics import Case, result
from mammosim.study.peers.summary import OURS

MEASURED = ("load_steps", "newton_iterations", "cpu_s", "memory_mb", "memory_before_mb")


def main(files: dict, job: dict, values: dict, program: dict, out: str) -> None:
    case, mesh = Case.of(values), read_mesh_arrays(files["mesh"])
    if program["missing"]:
        found = {"outcome": f"not installed: {program['missing']}"}
    else:
        command = [program["python"], files["adapter"], files["mesh"], files["coarse"]]
        facts = case.facts() | program["settings"]
        limits = {name: program[name] for name in ("cpu_limit_s", "arguments")}
        found = found_by(command, facts, **limits)
    facts = {name: found.get(name, np.nan) for name in MEASURED}
    about = result(case, mesh, found.get("u"), displacements_only=job["program"] != OURS)
    row = job | about | facts | {"outcome": found["outcome"]}
    write_table(pd.DataFrame([row]), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    names = snakemake.wildcards
    job = {"case": names.case, "edge_mm": float(names.edge), "program": names.program}
    main(dict(snakemake.input.items()), job, **_stage.settings(snakemake), out=snakemake.output[0])
