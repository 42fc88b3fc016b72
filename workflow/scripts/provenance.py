"""What made the results: versions, configuration, and every assumption in the code that ran."""

from pathlib import Path

import _log

from mammosim.io.tables import write_json
from mammosim.study.summary import assumptions, provenance


def main(lock: str, package: str, configuration: dict, out: str) -> None:
    root = Path(package)
    sources = {str(path.relative_to(root.parent)): path.read_text() for path in root.rglob("*.py")}
    write_json(provenance(configuration, lock=Path(lock).read_text(), assumed=assumptions(sources)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.input.lock,
        snakemake.params.package,
        snakemake.params.configuration,
        snakemake.output[0],
    )
