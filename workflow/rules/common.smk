# What every .smk file shares: where things are, and how settings are read and checked.
import os
import re
import runpy
import shlex
import sys
import tempfile
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.logging import logger

# The package of this checkout, whether it is installed or not, for the rules and for the scripts that they run.
sys.path.insert(0, str(HOME / "src"))
SEARCHED = [sys.path[0], *filter(None, os.getenv("PYTHONPATH", "").split(os.pathsep))]
os.environ.update(PYTHONPATH=os.pathsep.join(dict.fromkeys(SEARCHED)))
# Scripts end with the process that has started them: with this one, also in a job of a cluster.
os.environ.update(MAMMOSIM_RUN=str(os.getpid()))
# What was typed, for the footer of the report: jobs inherit it.
os.environ.setdefault("MAMMOSIM_COMMAND", shlex.join(["snakemake", *sys.argv[1:]]))

import mammosim
from mammosim.chain import configuration, relations
from mammosim.chain.graph import overridden
from mammosim.core.errors import ConfigurationError
from mammosim.io.plain import read_plain

PYTHON = sys.executable.strip("'")
# Snakemake hands this to a shell as it is, which cuts it at a blank (issue 3211 of snakemake).
sys.executable = shlex.quote(PYTHON)
# The solver that chooses the next jobs cannot read a file in a folder with a blank; jobs get the folder all the same.
if " " in tempfile.gettempdir():
    os.environ.update(TMP=".snakemake")
HERE = Path(os.path.relpath(HOME))  # as an input is recorded: the same when all of it is moved
PACKAGE = Path(mammosim.__file__).parent
SCRIPTS = HOME / "workflow" / "scripts"
# How many jobs run at a time: of a cluster, where one is told, which then need no number of cores.
AT_A_TIME = workflow.resource_settings.nodes or workflow.resource_settings.cores or 1
ON_CLUSTER = workflow.resource_settings.nodes is not None


def can_be_written(folder):
    """Whether there is such a folder, or one can be made, in which files can be made."""
    there = next((path for path in (folder, *folder.parents) if path.exists()), Path())
    return folder.is_absolute() and os.access(there, os.W_OK | os.X_OK)


# Compiled kernels, fonts: where a home cannot be written, or a user has none, they are kept with the run.
if not can_be_written(Path(os.path.expanduser(os.getenv("XDG_CACHE_HOME") or "~/.cache"))):
    CACHE = Path(".snakemake", "cache").resolve()
    os.environ.update(XDG_CACHE_HOME=str(CACHE))
    os.environ.setdefault("MPLCONFIGDIR", str(CACHE / "matplotlib"))
read_strictly = runpy.run_path(str(SCRIPTS / "_strict_yaml.py"))["read"]


def home(path):
    """A path of the study: as written where it exists, else in the folder of the checkout."""
    return path if Path(path).exists() else str(HERE / path)


def read_yaml(path):
    """The values of a file, rejected with its name and line where it cannot be read."""
    file = Path(home(path))
    if not file.exists():
        known = ", ".join(sorted(other.stem for other in file.parent.glob("*.yaml")))
        raise WorkflowError(f"ConfigurationError: there is no {path}; beside it are: {known or 'none'}")
    try:
        return read_strictly(file, str(path))
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None


@cache
def schema_of(kind):
    """The limits of all keys of a kind of file."""
    return read_yaml(f"workflow/schemas/{kind}.schema.yaml")


def checked(settings, schema, files, *, known=None, finite=True):
    """The settings, rejected with advice when a key or a value cannot be meant. files: names, or name -> its values."""
    limits, related = schema_of(schema), relations.RELATIONS.get(schema, ())
    try:
        configuration.check_settings(settings, limits, files=files, relations=related, known=known, finite=finite)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return settings


def given_settings():
    """What each file of the configuration gave, and the command line, later over earlier."""
    if OF_ANOTHER:
        return {str(DEFAULT): read_yaml(DEFAULT), "the config of the module": GIVEN_BY_ANOTHER}
    *overrides, default = workflow.configfiles  # the order in which Snakemake lists them
    files = {str(file): read_yaml(file) for file in (default, *overrides)}
    words = workflow.config_settings.config
    return files | ({"--config": words} if words else {})


def checked_overrides(values, file):
    """Settings that are laid over the study's, rejected where the study with them cannot be meant."""
    configuration.read_numbers(values, schema_of("config"))
    checked(overridden(config, values), "config", GIVEN | {file: values}, known=KNOWN)
    return values


def known_names():
    """Names that settings may choose from and that stand in files, whatever else is wrong with the settings."""
    tissues, scenes, accuracies = (stems(f"config/{folder}") for folder in ("tissues", "scenes", "accuracy"))
    files = {key: file_of(key) for key in relations.NAMING}
    strategies, recovery, table = (files[key] for key in ("compression.strategies_file", "recovery", "volunteer_table"))
    women = [place[-1] for place, _ in relations.entries(config, "digital.women.*")]
    seeds = [seed for _, seed in relations.entries(recovery and read_yaml(recovery), "seeds.*")]
    made = [f"made_{seed:02d}" for seed in seeds if isinstance(seed, int)]
    found = {
        relations.WOMEN: women,
        relations.FILES: [file for file in files.values() if file],
        relations.TISSUES: tissues,
        relations.MODULI: ["gravity", *tissues],
        relations.SCENES: scenes,
        relations.PUBLISHED: stems("config/models"),
        relations.ACCURACIES: ["study", *(name for name in accuracies if not name.startswith("parameters"))],
    }
    if strategies and isinstance(described := read_yaml(strategies), dict):
        found[relations.STRATEGIES] = list(described)
    if table:
        listed = [row["volunteer"] for row in rows_of(table, [*women, *made])]
        found[relations.VOLUNTEERS] = list(dict.fromkeys([*listed, *women, *made]))
    return found


def rows_of(table, digital):
    """The rows of the table of volunteers; every volunteer of the study has one, but for digital ones."""
    named = [name for _, name in relations.entries(config, "volunteers.*") if isinstance(name, str)]
    try:
        rows = read_plain(home(table))
        configuration.check_columns(rows, file=table)
        whom = [name for name in named if re.fullmatch("[a-z0-9_]+", name) and name not in digital]
        configuration.check_listed(rows, whom, file=table)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return rows


def file_of(setting):
    """The file that a setting names, None where it is no text, or there is no such file."""
    named = [file for _, file in relations.entries(config, setting) if isinstance(file, str)]
    return next((file for file in named if Path(home(file)).is_file()), None)


def stems(folder):
    """Names of the YAML files in a folder of the study, and of the folder where it runs."""
    there = [file for root in (HOME, Path()) for file in (root / folder).glob("[!.]*")]
    for file in there:
        if file.suffix != ".yaml" and file.suffix.lower() in (".yml", ".yaml"):
            raise WorkflowError(f"ConfigurationError: {file} would not be read: its name is to end in .yaml; rename it")
    return sorted({file.stem for file in there if file.suffix == ".yaml"})


# A workflow of which this one is a module gives what is to be otherwise than in the published study.
DEFAULT = HOME / "config" / "default.yaml"
OF_ANOTHER = not workflow.modifier.is_main_snakefile()
GIVEN_BY_ANOTHER = config if OF_ANOTHER else {}
if OF_ANOTHER:
    config = overridden(read_yaml(DEFAULT), GIVEN_BY_ANOTHER)
if os.path.lexists("results") and not Path("results").is_dir():
    raise WorkflowError(f"{Path('results').absolute()} is no folder; move it, or run the study with --directory elsewhere")
if workflow.is_main_process and Path("results/checked").is_dir() and not any(Path(".snakemake/metadata").glob("*")):
    logger.warning(
        "results/ came without .snakemake: no record says with which settings, data and versions they were made, and "
        "they are taken as they are. Copy .snakemake with them, or make them anew by --forceall."
    )
# What one job of each was measured to take, by name of the rule.
COSTS = {row["rule"]: row for row in read_plain(home("config/costs.tsv"))}
GIVEN = given_settings()
KNOWN = known_names()
checked(config, "config", GIVEN, known=KNOWN)
