"""What made the results: versions, configuration, and every assumption in the code that ran."""

import os
import subprocess
from os.path import commonpath
from pathlib import Path

import _log

from mammosim.io.tables import write_json
from mammosim.study.report.summary import assumptions, provenance


def main(lock: str, files: list[str], configuration: dict, out: str) -> None:
    root = Path(commonpath(files))
    sources = {str(Path(file).relative_to(root)): Path(file).read_text() for file in files}
    made = provenance(
        configuration,
        lock=Path(lock).read_text(),
        assumed=assumptions(sources),
        commit=commit_of(Path(lock).parent),
        command=os.environ.get("MAMMOSIM_COMMAND", ""),
    )
    write_json(made, out)


def commit_of(home: Path) -> str:
    """The commit of a checkout, with -dirty where files were edited since; '' where it is none."""
    command = ["git", "-C", str(home), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=20, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return found.stdout.strip() if (home / ".git").exists() else ""


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.input.lock,
        snakemake.input.sources,
        snakemake.params.configuration,
        snakemake.output[0],
    )
