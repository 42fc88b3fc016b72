"""What made the results: versions, configuration, and every assumption in the code that ran."""

from os.path import commonpath
from pathlib import Path

import _log

from mammosim.io.tables import write_json
from mammosim.study.report.summary import assumptions, provenance


def main(lock: str, files: list[str], configuration: dict, out: str) -> None:
    root = Path(commonpath(files))
    sources = {str(Path(file).relative_to(root)): Path(file).read_text() for file in files}
    write_json(provenance(configuration, lock=Path(lock).read_text(), assumed=assumptions(sources)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        snakemake.input.lock,
        snakemake.input.sources,
        snakemake.params.configuration,
        snakemake.output[0],
    )
