"""What the report says of the whole study: numbers by name, assumptions, sources, what made it."""

import hashlib
import json
import os
import platform
import re
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any
from unicodedata import normalize

import pandas as pd

from mammosim import __version__

# What sentences quote, by dotted name, e.g. sweep.small.1.nipple_left_mm; None where there is none.
Numbers = Mapping[str, float | str | None]
# The nested plain values of a configuration, as YAML has them.
Configuration = Mapping[str, object]

PACKAGES = (
    "mammosim",
    "gmsh",
    "numba",
    "numpy",
    "pandas",
    "pypardiso",
    "rslab",
    "scikit-fem",
    "scikit-learn",
    "scipy",
    "simpleitk",
    "snakemake",
    "spekpy",
    "xraylib",
)
ASSUMPTION = re.compile(r"^\s*# ASSUME: (.*)$")
CONTINUED = re.compile(r"^\s*# (?!ASSUME)(.*)$")


def numbers(
    tables: Mapping[str, pd.DataFrame], keys: Mapping[str, tuple[str, ...]]
) -> dict[str, float | str | None]:
    """Every number of the tables by name: table.key.key.column, e.g. sweep.small.1.nipple_left_mm.

    keys: table -> the columns that tell its rows apart. A missing number is None.
    Raises KeyError for a column that a table lacks, ValueError when two rows share their keys.
    """
    found: dict[str, float | str | None] = {}
    for name, table in tables.items():
        by = list(keys.get(name, ()))
        if by and table.duplicated(by).any():
            raise ValueError(f"rows of {name} are not told apart by {', '.join(by)}")
        for row in table.to_dict("records"):
            prefix = ".".join([name, *(_word(row[key]) for key in by)])
            found |= {
                f"{prefix}.{column}": _plain(row[column]) for column in table.columns if column not in by
            }
    return found


def _word(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value).replace(" ", "_")


def _plain(value: float | str) -> float | str | None:
    if pd.isna(value):
        return None
    return value.item() if hasattr(value, "item") else value


def assumptions(sources: Mapping[str, str]) -> pd.DataFrame:
    """Every `# ASSUME:` of source texts, given by file name: columns file, assumption.

    A comment that goes on in the next line is read to its end.
    """
    rows = []
    for file, text in sorted(sources.items()):
        lines = text.splitlines()
        for number, line in enumerate(lines):
            if match := ASSUMPTION.match(line):
                rows.append((file, " ".join([match[1].strip(), *_continued(lines[number + 1 :])])))
    return pd.DataFrame(rows, columns=["file", "assumption"])


def _continued(lines: Iterable[str]) -> Iterable[str]:
    for line in lines:
        match = CONTINUED.match(line)
        if not match:
            return
        yield match[1].strip()


def provenance(
    configuration: Configuration, *, lock: str, assumed: pd.DataFrame, commit: str = "", command: str = ""
) -> dict[str, object]:
    """Versions, the kind of machine, and digests of the configuration and of the environment's lock.

    commit: of the checkout; command: that started the run; '' where unknown.
    """
    return {
        "commit": commit or "unknown: the study does not lie in a checkout of git",
        "command": command or "unknown",
        "machine": machine_kind(),
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in PACKAGES},
        "configuration_sha256": digest(configuration),
        "environment_sha256": hashlib.sha256(lock.encode()).hexdigest(),
        "configuration": dict(configuration),
        "assumptions": assumed.to_dict("records"),
    }


def machine_kind() -> str:
    """System, processor, cores and memory; not which machine it is."""
    told = Path("/proc/cpuinfo").read_text(errors="replace") if Path("/proc/cpuinfo").exists() else ""
    model = re.search(r"^model name\s*:\s*(.+)$", told, re.M)
    gigabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    processor = model[1].strip() if model else platform.machine()
    return (
        f"{platform.system()} {platform.machine()}, {processor}, {os.cpu_count()} cores, {gigabytes:.0f} GB"
    )


def made_words(made: Mapping[str, Any], *, date: str, jobs: pd.DataFrame | None = None) -> dict[str, str]:
    """What made a page, name -> words, of the values of provenance.json.

    jobs: one row per job with s, cpu_time (s) and max_rss (MB), as Snakemake's benchmarks have them.
    """
    packages, settings = made["packages"], made["configuration"]
    found = {
        "Date": date,
        "Commit": str(made.get("commit", "unknown")),
        "Machine": str(made.get("machine", "unknown")),
        "Command": str(made.get("command", "unknown")),
        "Seeds": f"{settings['seed']}, and one of each job by its name" if "seed" in settings else "none",
        "Versions": f"mammosim {packages['mammosim']}, Python {made['python']}",
        "Settings": f"SHA-256 {made['configuration_sha256'][:12]}; lock {made['environment_sha256'][:12]}",
    }
    if jobs is None or jobs.empty:
        return found
    hours, weighed = jobs.cpu_time.sum() / 3600, jobs.dropna(subset=["max_rss"]).sort_values("max_rss")
    took = f"{len(jobs)} jobs, {hours:.1f} processor hours, {jobs.s.sum() / 3600:.1f} hours one after another"
    most = [f"at most {row.max_rss / 1000:.1f} GB ({row.rule})" for row in weighed.tail(1).itertuples()]
    return found | {"Durations": "; ".join([took, *most])}


def digest(values: Configuration) -> str:
    """SHA-256 of nested values, whatever the order of their keys."""
    return hashlib.sha256(json.dumps(values, sort_keys=True, default=str).encode()).hexdigest()


def _version(name: str) -> str:
    if name == "mammosim":  # which may be linked, not installed
        return __version__
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


ENTRY = re.compile(r"@(\w+)\{(\w+),(.*?)\n\}", re.S)
FIELD = re.compile(r"(\w+) = \{(.*?)\},?\s*(?=\n|$)", re.S)
ACCENT = re.compile(r"\{\\([\"'`^~])\\?(\w)\}")  # of LaTeX, as {\"o}
COMBINING = {'"': "\u0308", "'": "\u0301", "`": "\u0300", "^": "\u0302", "~": "\u0303"}


def entries(text: str) -> list[dict[str, str]]:
    """key, author, year, title and where it appeared, of every entry, sorted by key."""
    rows = []
    for _, key, body in ENTRY.findall(text):
        fields = {name: _plain_text(value) for name, value in FIELD.findall(body)}
        where = fields.get("journal") or fields.get("institution", "")
        rows.append(
            {"key": key, "author": fields.get("author", ""), "year": fields.get("year", "")}
            | {"title": fields.get("title", ""), "in": f"{where} {fields.get('volume', '')}".strip()}
        )
    return sorted(rows, key=lambda row: row["key"])


def author_year(entry: Mapping[str, str]) -> str:
    """How a text cites an entry of `entries`: 'Mîra et al. 2018', 'Dance and Sechopoulos 2016'."""
    families = [name.split(",")[0].strip() for name in entry["author"].split(" and ")]
    named = families[0] if len(families) == 1 else " and ".join(families)
    if len(families) > 2 or families[-1] == "others":
        named = f"{families[0]} et al."
    return f"{named} {entry['year']}".strip()


def _plain_text(value: str) -> str:
    accented = ACCENT.sub(lambda found: normalize("NFC", found[2] + COMBINING[found[1]]), value)
    return accented.replace("{", "").replace("}", "").replace("\\", "")
