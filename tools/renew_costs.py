"""Renew config/costs.tsv from what Snakemake measured: `python tools/renew_costs.py results/benchmarks ...`.

The first folder is of the study; further ones, of other women, count for the longest job and the largest
memory only. Rules that did not run keep their line; rules that are gone lose it. Lines `point_...` stay: what
a product takes in a campaign, without the start of a script.
"""

import subprocess
import sys
from pathlib import Path

import pandas as pd
from pandas.api.typing import DataFrameGroupBy

from mammosim.study.jobs.plan import costed_as

HOME = Path(__file__).parents[1]
COSTS = HOME / "config" / "costs.tsv"
HEAD = "# what one job of a rule takes in the default study: processor seconds; of its largest jobs, of\n"
HEAD += "# whatever woman and strategy: memory in MB, processor seconds;\n"
HEAD += "# read by the estimate of the time left, `snakemake plan` and what jobs ask a cluster for;\n"
HEAD += "# point_...: a product in a campaign, without a script's start; renewed by tools/renew_costs.py\n"


def measured(*folders: Path) -> DataFrameGroupBy:
    """The benchmarks of all jobs, by rule."""
    files = [path for folder in folders for path in sorted(folder.glob("*/*.tsv"))]
    return pd.concat(
        [pd.read_table(path).assign(rule=costed_as(path.parent.name)) for path in files]
    ).groupby("rule")


def rules() -> set[str]:
    """The names of all rules, as Snakemake lists them: some are made in a loop."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(HOME / "workflow/Snakefile")]
    command += ["--workflow-profile", "none", "--list-rules"]
    ran = subprocess.run(command, cwd=HOME, text=True, stdout=subprocess.PIPE, check=True)
    return {costed_as(line.split()[0]) for line in ran.stdout.splitlines() if line}


def main(study: Path, *others: Path) -> None:
    largest = measured(study, *others).agg(memory_mb=("max_rss", "max"), longest=("cpu_time", "max"))
    means = measured(study).cpu_time.mean().combine_first(measured(study, *others).cpu_time.mean())
    before = pd.read_table(COSTS, comment="#").set_index("rule")
    table = largest.assign(seconds=means).combine_first(before)
    table = table.round({"seconds": 1, "memory_mb": 0, "longest": 1}).sort_index()
    table = table[table.index.isin(rules()) | table.index.str.startswith("point_")]
    COSTS.write_text(HEAD + table[["seconds", "memory_mb", "longest"]].to_csv(sep="\t", lineterminator="\n"))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
