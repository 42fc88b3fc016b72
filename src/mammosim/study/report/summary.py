"""What the report says of the whole study: numbers by name, assumptions, sources, what made it."""

import hashlib
import json
import platform
import re
from collections.abc import Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version

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


def provenance(configuration: Configuration, *, lock: str, assumed: pd.DataFrame) -> dict[str, object]:
    """Versions, and digests of the configuration and of the text of the environment's lock."""
    return {
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in PACKAGES},
        "configuration_sha256": digest(configuration),
        "environment_sha256": hashlib.sha256(lock.encode()).hexdigest(),
        "configuration": dict(configuration),
        "assumptions": assumed.to_dict("records"),
    }


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
ACCENT = re.compile(r"\{\\\^i\}")


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


def _plain_text(value: str) -> str:
    return ACCENT.sub("î", value).replace("{", "").replace("}", "").replace("\\", "")
