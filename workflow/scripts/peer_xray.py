"""One program, one X-ray task: run by its own Python on one thread, within a limit of processor time."""

import _log
import pandas as pd

from mammosim.io.programs import found_by
from mammosim.io.tables import write_table
from mammosim.study.peers.xray import Answer, row_of, task_of


def main(files: dict, job: dict, task: dict, program: dict, out: str) -> None:
    if program["missing"]:
        found = {"outcome": f"not installed: {program['missing']}"}
    else:
        command = [program["python"], files["adapter"], files["problem"], files["small"]]
        limits = {name: program[name] for name in ("cpu_limit_s", "arguments")}
        found = found_by(command, program["settings"], **limits)
    row = row_of(task_of(**task), Answer(**found), task["values"].get("relative_error"))
    write_table(pd.DataFrame([job | {"kind": task["kind"]} | row]), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    names, given = snakemake.wildcards, snakemake.params
    job = {"task": names.task, "program": names.program}
    task = {"kind": given.kind, "values": given.values}
    main(dict(snakemake.input.items()), job, task, given.program, snakemake.output[0])
