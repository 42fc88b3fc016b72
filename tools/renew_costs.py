"""Renew config/costs.tsv from what Snakemake measured: `python tools/renew_costs.py results/benchmarks`.

Rules that did not run keep their line; rules that are gone lose it. Lines `point_...` stay: what a
product takes in a campaign, without the start of a script.
"""

import re
import sys
from pathlib import Path

import pandas as pd

HOME = Path(__file__).parents[1]
COSTS = HOME / "config" / "costs.tsv"
HEAD = "# what one job of a rule takes in the default study: processor seconds, largest memory in MB;\n"
HEAD += "# read by the estimate of the time left, `snakemake plan` and what jobs ask a cluster for;\n"
HEAD += "# point_...: a product in a campaign, without a script's start; renewed by tools/renew_costs.py\n"


def main(folder: Path) -> None:
    parts = [pd.read_table(path).assign(rule=path.parent.name) for path in sorted(folder.glob("*/*.tsv"))]
    measured = (
        pd.concat(parts).groupby("rule").agg(seconds=("cpu_time", "mean"), memory_mb=("max_rss", "max"))
    )
    before = pd.read_table(COSTS, comment="#").set_index("rule")
    texts = [path.read_text(encoding="utf-8") for path in (HOME / "workflow/rules").glob("*.smk")]
    rules = {
        name for text in texts for name in re.findall(r"^(?:rule|checkpoint) (\w+):", text, re.MULTILINE)
    }
    table = measured.combine_first(before).round({"seconds": 1, "memory_mb": 0}).sort_index()
    table = table[table.index.isin(rules) | table.index.str.startswith("point_")]
    COSTS.write_text(HEAD + table[["seconds", "memory_mb"]].to_csv(sep="\t", lineterminator="\n"))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
