"""The results as an RO-Crate: a folder with every table, figure and page, and what made them."""

from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path

import _log

from mammosim.core.errors import ConfigurationError
from mammosim.io.tables import read_json

INSTALL = "rocrate is not installed: `make` installs it, or pip install '.[crate]'"
# What a reader sees of each file; others are found by their names.
TOLD = {
    "report.html": "Every figure and table on one page, with the figures and scripts beside it",
    "numbers.json": "Every quoted number",
    "provenance.json": "Versions, configuration and assumptions",
    "missing.csv": "What could not be computed, and why",
    "not_planned.csv": "What the data of a volunteer do not allow, and why",
}


def main(home: Path, files: Iterable[str], out: Path) -> None:
    """Write the crate into the folder `out`. files: of the results, the report first."""
    try:
        from rocrate.rocrate import ROCrate
    except ImportError:
        raise ConfigurationError(INSTALL) from None
    results = [Path(file) for file in files]
    crate = ROCrate()
    crate.name = "mammosim: results of a study"
    crate.description = "From breast MR images to compression, X-ray images and dose"
    crate.license = "MIT"
    crate.datePublished = datetime.fromtimestamp(results[0].stat().st_mtime, UTC)
    workflow, sources = add_workflow(crate, home)
    made = [add_result(crate, file) for file in results]
    add_run(crate, workflow, sources, made, versions(results))
    crate.write(out)


def add_workflow(crate, home: Path):
    """The workflow, and the files that it is made of: rules, scripts, settings, package, environment."""
    main_file = home / "workflow/Snakefile"
    workflow = crate.add_workflow(main_file, "workflow/Snakefile", main=True, lang="snakemake")
    kept = [path for folder in ("workflow", "config", "src") for path in sorted((home / folder).rglob("*"))]
    kept = [path for path in kept if path.is_file() and "__pycache__" not in path.parts and path != main_file]
    kept += [home / name for name in ("environment.lock", "pyproject.toml", "LICENSE", "CITATION.cff")]
    found = [path for path in kept if path.exists()]
    return workflow, [crate.add_file(path, str(path.relative_to(home))) for path in found]


def add_result(crate, file: Path):
    """One file of the results, where it lies in the study."""
    properties = {"name": TOLD.get(file.name, file.stem.replace("_", " "))}
    return crate.add_file(file, str(file), properties=properties, record_size=True)


def add_run(crate, workflow, sources: list, made: list, programs: Mapping[str, str]) -> None:
    """The run that made the results, by which versions."""
    run = crate.add_action(workflow, identifier="#run", object=sources, result=made)
    run["name"] = "A run of the study"
    run["description"] = ", ".join(f"{name} {version}" for name, version in sorted(programs.items()))
    crate.root_dataset["mentions"] = [run]


def versions(results: Iterable[Path]) -> dict[str, str]:
    """Program -> version, of what provenance.json lists."""
    listed = [read_json(file) for file in results if file.name == "provenance.json"]
    return {name: str(version) for each in listed for name, version in each.get("packages", {}).items()}


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(Path(snakemake.params.home), list(snakemake.input.results), Path(snakemake.output[0]))
