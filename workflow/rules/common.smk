# What every .smk file shares: where things are, and how settings are read and checked.
import shlex
import sys
from functools import cache
from pathlib import Path

import yaml
from snakemake.exceptions import WorkflowError

from mammosim.chain import configuration
from mammosim.core.errors import ConfigurationError
from mammosim.io.plain import not_finite, read_plain, repeated

PYTHON = sys.executable.strip("'")
# Snakemake hands this to a shell as it is, which cuts it at a blank (issue 3211 of snakemake).
sys.executable = shlex.quote(PYTHON)
HOME = Path(workflow.basedir)
PACKAGE = HOME / "src" / "mammosim"
SCRIPTS = HOME / "workflow" / "scripts"


def home(path):
    """A path of the study: as written where it exists, else beside the Snakefile."""
    return path if Path(path).exists() else str(HOME / path)


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """YAML that refuses a key that is given twice."""

    def construct_mapping(self, node, deep=False):
        keys = [key for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        if twice := repeated([key.value for key in keys]):
            lines = [str(key.start_mark.line + 1) for key in keys if key.value == twice[0]]
            raise yaml.constructor.ConstructorError(
                None, None, f"{twice[0]!r} is given twice, in lines {' and '.join(lines)}; keep one", keys[0].start_mark
            )
        return super().construct_mapping(node, deep=deep)


def read_yaml(path):
    """The values of a file, refused with its name and line where it cannot be read."""
    file = Path(home(path))
    if not file.exists():
        known = ", ".join(sorted(other.stem for other in file.parent.glob("*.yaml")))
        raise WorkflowError(f"ConfigurationError: there is no {path}; beside it are: {known or 'none'}")
    try:
        return yaml.load(file.read_text(encoding="utf-8"), Loader=Loader)
    except yaml.MarkedYAMLError as error:
        line = error.problem_mark.line + 1 if error.problem_mark else "?"
        raise WorkflowError(f"ConfigurationError: {path}, line {line}: {error.problem}") from None


def checked(settings, schema, files, *, finite=True):
    """The settings, refused with advice when a key or a value cannot be meant."""
    if finite and (odd := not_finite(settings)):
        raise WorkflowError(f"ConfigurationError: {', '.join(files)}: {odd[0]} is not a finite number; write one")
    try:
        configuration.check_settings(settings, read_yaml(f"workflow/schemas/{schema}.schema.yaml"), files=files)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return settings


[read_yaml(file) for file in workflow.configfiles]  # each can be read, and gives no key twice
checked(config, "config", [str(file) for file in workflow.configfiles])
