"""What the jobs of a run took, beside what they would ask a cluster for: `efficiency.py results/benchmarks`.

A line per rule, the most wasteful first; where a job took more than it would ask for, its rule is marked.
"""

import sys
from pathlib import Path

import pandas as pd

HOME = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HOME / "src"))

from mammosim.io.plain import read_plain  # noqa: E402
from mammosim.study.jobs.requests import Request, requests  # noqa: E402

HEAD = f"{'rule':24}{'jobs':>6}{'CPU %':>7}{'MB':>7}{'of':>7}{'min':>7}{'of':>6}\n"


def main(folder: Path) -> str:
    """The table as text."""
    rows = {row["rule"]: row for row in read_plain(HOME / "config/costs.tsv")}
    asked = requests({rule: 0.0 for rule, row in rows.items() if row["memory_mb"]}, rows)
    parts = [pd.read_table(path).assign(rule=path.parent.name) for path in sorted(folder.glob("*/*.tsv"))]
    if not parts:
        return f"{folder} has no benchmarks: give results/benchmarks of a run\n"
    took = (
        pd.concat(parts)
        .groupby("rule")
        .agg(
            jobs=("s", "size"),
            seconds=("s", "sum"),
            longest=("s", "max"),
            cpu=("cpu_time", "sum"),
            mb=("max_rss", "max"),
        )
    )
    known = took[took.index.isin(asked)].assign(
        unused=lambda t: t.jobs * [asked[r].mem_mb(1) for r in t.index]
    )
    known = known.assign(unused=known.unused - known.jobs * known.mb).sort_values("unused", ascending=False)
    return HEAD + "".join(line(each, asked[str(each.Index)]) for each in known.itertuples())


def line(took, asked: Request) -> str:
    """One rule: jobs, share of its core, largest memory and time beside those asked for."""
    mb, minutes = asked.mem_mb(1), asked.runtime(1)
    share = 100 * took.cpu / max(took.seconds, 1e-9)
    over = "  more than asked for" if took.mb > mb or took.longest / 60 > minutes else ""
    numbers = f"{took.jobs:6d}{share:7.0f}{took.mb:7.0f}{mb:7d}{took.longest / 60:7.1f}{minutes:6d}"
    return f"{took.Index:24}{numbers}{over}\n"


if __name__ == "__main__":
    sys.stdout.write(main(Path(sys.argv[1])))
