"""The plan of a run: dry runs of its targets, at what their rules cost when they were measured."""

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import _benchmarks
import _log
import _stage
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.progress import progress
from mammosim.io.tables import read_commented, read_json, read_table, write_table
from mammosim.study.accuracy.presets import as_imaged, pace_at
from mammosim.study.campaigns.prediction import expected
from mammosim.study.campaigns.prediction import measured as took
from mammosim.study.jobs.plan import costs, jobs_of, plan, scene_lines, summary, words


def main(
    files: Mapping[str, str], settings: Mapping, scenes: Mapping[str, list[str] | str], out: str
) -> None:
    targets = progress(settings["targets"], label="dry runs", total=len(settings["targets"]))
    jobs = {
        target: jobs_of(dry_run([*settings["dry_run"], target]), idle=settings["idle"]) for target in targets
    }
    known = costs(
        _benchmarks.benchmarks(Path("results/benchmarks")), pd.read_table(files["costs"], comment="#")
    )
    batches = {
        name: batch_seconds(given, known, files["measured"]) for name, given in settings["campaigns"].items()
    }
    table = plan(jobs, known, batches)
    write_table(table, out)
    found = summary(table, jobs, cores=settings["cores"])
    effects = effects_of(scenes)
    at_least = ["scenes"] if any(each is None for each in effects.values()) else []
    told = words(found, table, scene_lines(effects), cores=settings["cores"], at_least=at_least)
    sys.stdout.write(f"{told}\n")


def batch_seconds(given: Mapping, known: pd.DataFrame, measured: str) -> float:
    """What the batches of one campaign will take, by its points that are finished, or by the tables."""
    if not given["points"]:
        return 0.0
    rows = [row for path in sorted(Path().glob(given["batches"])) for row in read_json(path)]
    return expected(
        given["made"],
        known.seconds.to_dict(),
        pace=pace_at(as_imaged(read_commented(measured)), given["settings"], given["quantities"]),
        points=given["points"],
        batches=given["jobs"],
        took=took(rows, given["kinds"]),
    )


def dry_run(command: list[str]) -> str:
    """What Snakemake says it would do. Raises ConfigurationError with its words where it fails."""
    ran = subprocess.run(command, text=True, capture_output=True, check=False)
    if ran.returncode:
        raise ConfigurationError(
            f"{command[-1]} cannot be planned: {(ran.stderr or ran.stdout).strip()[-2000:]}"
        )
    return ran.stdout + ran.stderr


def effects_of(scenes: Mapping[str, list[str] | str]) -> dict[str, pd.DataFrame | list[str] | None]:
    """The effects of each scene: listed, or its rows of the file of its screening, if that was made."""
    return {
        name: given if isinstance(given, list) else screened(name, given) for name, given in scenes.items()
    }


def screened(scene: str, path: str) -> pd.DataFrame | None:
    """The rows of one scene, or None where it was not screened yet."""
    if not Path(path).exists():
        return None
    rows = read_table(path, may_be_empty=True)
    rows = rows[rows.scene == scene]
    return rows if len(rows) else None


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    settings = _stage.settings(snakemake)
    main(dict(snakemake.input.items()), settings, settings.pop("scenes"), snakemake.output[0])
