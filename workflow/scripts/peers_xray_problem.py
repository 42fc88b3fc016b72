"""An X-ray task as every program reads it."""

import _log
import _stage

from mammosim.io.programs import write_problem
from mammosim.study.peers.xray import task_of


def main(kind: str, values: dict, out: dict[str, str]) -> None:
    task = task_of(kind, values)
    write_problem(*task.problem(), out["problem"])
    write_problem(*task.small().problem(), out["small"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(**_stage.settings(snakemake), out=dict(snakemake.output.items()))
