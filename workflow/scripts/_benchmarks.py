"""What jobs took, as Snakemake measured it."""

from pathlib import Path

import pandas as pd

MEASURED = ("s", "cpu_time", "max_rss")  # in s, s and MB


def benchmarks(folder: Path) -> pd.DataFrame:
    """A row per job that ran here: rule, s, cpu_time, max_rss, ...; NaN where one was too short for it."""
    files = [path for path in sorted(folder.glob("*/*.tsv")) if path.stat().st_size]
    parts = [pd.read_table(path).assign(rule=path.parent.name) for path in files]
    jobs = pd.concat([pd.DataFrame(columns=["rule", *MEASURED]), *parts], ignore_index=True)
    return jobs.assign(**{name: pd.to_numeric(jobs[name], errors="coerce") for name in MEASURED})
