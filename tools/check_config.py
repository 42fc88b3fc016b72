"""Check files of settings as a run would, by file, key and line: `python tools/check_config.py mine.yaml`.

A dry run says the same of all but what is no YAML at all: snakemake reads `--configfile` first, and does not
say which file it is, or where. Only a dry run looks for the files that settings name.
Later files are laid over earlier ones, and all over config/default.yaml.
"""

import argparse
import runpy
import sys
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HOME / "src"))

from mammosim.chain.configuration import check_settings  # noqa: E402
from mammosim.chain.graph import overridden  # noqa: E402
from mammosim.chain.relations import RELATIONS  # noqa: E402
from mammosim.core.errors import ConfigurationError  # noqa: E402

read = runpy.run_path(str(HOME / "workflow/scripts/_strict_yaml.py"))["read"]


def check(files: list[str]) -> None:
    """Raise ConfigurationError with all faults of the default with these files laid over it."""
    given = {"config/default.yaml": read(HOME / "config/default.yaml")} | {file: read(file) for file in files}
    settings: dict = {}
    for file, values in given.items():
        if not isinstance(values, dict):
            raise ConfigurationError(f"{file} has no keys; write settings as in config/default.yaml")
        settings = overridden(settings, values)
    schema = read(HOME / "workflow/schemas/config.schema.yaml")
    check_settings(settings, schema, files=given, relations=RELATIONS["config"])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", help="files of settings, as given by --configfile")
    files = parser.parse_args().files
    try:
        check(files)
    except ConfigurationError as error:
        sys.exit(f"ConfigurationError: {error}")
    sys.stdout.write(f"{', '.join(files)}: nothing to correct\n")
