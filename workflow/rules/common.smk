# What every .smk file shares: the checked configuration, and the package files that a script depends on.
import shlex
import sys
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import yaml
from snakemake.exceptions import WorkflowError

from mammosim.chain import configuration
from mammosim.core.errors import ConfigurationError
from mammosim.core.positions import GRAVITY
from mammosim.io.plain import not_finite, read_plain, repeated
from mammosim.study.jobs import code as source_code

PYTHON = sys.executable.strip("'")
# Snakemake hands this to a shell as it is, which cuts it at a blank (issue 3211 of snakemake).
sys.executable = shlex.quote(PYTHON)
HOME = Path(workflow.basedir)
PACKAGE = HOME / "src" / "mammosim"
SCRIPTS = HOME / "workflow" / "scripts"
TABLE = PACKAGE / "chain" / "stages.py"


def home(path):
    """A path of the study: as written where it exists, else beside the Snakefile."""
    return path if Path(path).exists() else str(HOME / path)


class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """YAML that refuses a key that is given twice."""

    def construct_mapping(self, node, deep=False):
        if twice := repeated([key.value for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]):
            raise yaml.constructor.ConstructorError(
                None, None, f"the key {twice[0]!r} is given twice; keep one of them", node.start_mark
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


def tissue_table(name):
    """The parameters of config/tissues/{name}.yaml, complete for every tissue that segmentation finds."""
    file = f"config/tissues/{name}.yaml"
    table = checked(read_yaml(file), "tissues", [file])
    try:
        configuration.check_tissues(table["tissues"], ["adipose", "glandular", "muscle"], file=file)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return table


def volunteer_table(file):
    """config/volunteers.tsv as (volunteer, position) -> row, each gravity in agreement with its position.

    A digital woman who is not studied by default has rows, too: where the rules that make her put her scans.
    """
    listed = read_plain(home(file))
    others = [digital_row(w, p) for w in DIGITAL if w not in config["volunteers"] for p in lying(w)]
    rows = [*(row for row in listed if row["volunteer"] in config["volunteers"]), *others]
    try:
        configuration.check_listed(listed, config["volunteers"], file=file)
        configuration.check_volunteers(rows, file=file, reference_position=config["reference_position"])
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return {(row["volunteer"], row["position"]): SimpleNamespace(**row) for row in rows}


def lying(woman):
    """The positions that a digital woman is scanned in."""
    return RECOVERY["positions"] if woman in MADE else ["prone", "supine", "supine_tilted"]


def digital_row(woman, position):
    """Her line of the volunteer table."""
    scan = f"results/raw/{woman}/{position}"
    return {
        "volunteer": woman,
        "position": position,
        "images": scan,
        "fiducials": f"{scan}_fiducials.csv",
        "strokes": f"{scan}_strokes.csv",
        "gravity": " ".join(f"{component:.4g}" for component in GRAVITY[position]),
    }


@cache
def imports_of(file):
    """The package files that one file names, and the tables and templates that it reads."""
    text = file.read_text(encoding="utf-8")
    modules = [HOME / "src" / Path(*name.split(".")) for name in dict.fromkeys(source_code.imported(text))]
    found = [path for module in modules for path in (module.with_suffix(".py"), module / "__init__.py")]
    found += [PACKAGE / "io" / "data" / f"{name}.csv" for name in source_code.tables(text)]
    found += [PACKAGE / "study" / "report" / "templates" / name for name in source_code.templates(text)]
    return tuple(path for path in found if path.exists())


def library(script):
    """Every file of the package that a script depends on, directly or not: editing one reruns the rule."""
    return dependencies([SCRIPTS / script])


def dependencies(files):
    """Every file of the package that these depend on, those of the package included.

    The table of the stages is left out: what it says of a job shows in the job's own inputs and parameters.
    """
    open_files = list(files)
    found = {path for path in files if PACKAGE in path.parents}
    while open_files:
        for path in imports_of(open_files.pop()):
            if path not in found and path != TABLE:
                found.add(path)
                open_files += [path] if path.suffix == ".py" else []
    return sorted(map(str, found))


[read_yaml(file) for file in workflow.configfiles]  # each can be read, and gives no key twice
checked(config, "config", [str(file) for file in workflow.configfiles])
RECOVERY = checked(read_yaml(config["recovery"]), "recovery", [config["recovery"]])
MADE = {f"made_{seed:02d}": seed for seed in RECOVERY["seeds"]}  # volunteer -> seed, on demand
DIGITAL = [*config["digital"]["women"], *MADE]
VOLUNTEERS = volunteer_table(config["volunteer_table"])
TISSUES = tissue_table(config["tissues"])
WOMEN = list(config["volunteers"])
DIGITAL_WOMEN = [v for v in WOMEN if v in config["digital"]["women"]]
REFERENCE = config["reference_position"]
PAGES = {}  # of results made on demand, target -> the tables and figures that its page shows


def page(target):
    """What the page of a target is made of: its text, its numbers, and the tables and figures of PAGES."""
    return {
        "text": page_text(target),
        "numbers": f"results/study/{target}.json",
        "tables": expand("results/study/{name}.csv", name=PAGES[target]["tables"]),
        "pictures": expand("results/study/figures/{name}.png", name=PAGES[target]["figures"]),
    }


def page_text(target):
    """The file that says what stands on a page."""
    return str(HOME / "workflow" / "report" / f"{target}.yaml")


def made_pages(wildcards):
    """The numbers, tables and figures of every page that has been made: the report shows them, too."""
    made = []
    for parts in map(page, PAGES):
        files = [parts["numbers"], *parts["tables"], *parts["pictures"]]
        made += files if all(Path(file).exists() for file in files) else []
    return made


def positions(volunteer):
    """The positions that a volunteer was scanned in."""
    return [position for name, position in VOLUNTEERS if name == volunteer]


def moving(volunteer):
    """The positions that are moved into the reference position's frame."""
    return [position for position in positions(volunteer) if position != REFERENCE]


def scanned(template, which=positions):
    """A path for every volunteer and position."""
    return [template.format(v=v, p=p) for v in WOMEN for p in which(v)]


def scored(template, which):
    """A path for every digital volunteer and each of `which(volunteer)`."""
    return [template.format(v=v, p=p) for v in DIGITAL_WOMEN for p in which(v)]


def scored_of(volunteer, what):
    """The score of a digital volunteer, none of a real one."""
    return [f"results/scores/{volunteer}/{what}.csv"] if volunteer in DIGITAL_WOMEN else []


def over(template, **values):
    """A path for every volunteer and every combination of the values."""
    return expand(template, v=WOMEN, **values)


def others_checked(wildcards):
    """That every image of the study is usable; a volunteer beside the study answers for her own only."""
    return ["results/checked/all.csv"] if wildcards.v in WOMEN else []


def asked_settings():
    """The words by which this run was given its settings, for another one."""
    given = workflow.config_settings
    files = [str(Path(file).resolve()) for file in given.configfiles]
    values = given.config_args
    return [*(["--configfile", *files] if files else []), *(["--config", *values] if values else [])]


def row(wildcards):
    """The line of the volunteer table."""
    return VOLUNTEERS[wildcards.v, wildcards.p]


def gravity(volunteer, position):
    """Its direction in the scanner frame of that position, 'x y z'."""
    return VOLUNTEERS[volunteer, position].gravity


def pair_inputs(wildcards):
    """Meshes, fiducials and transforms of the two positions."""
    files = {"start_transform": f"results/registration/{wildcards.v}/prone.tfm"}
    for name, position in zip(("start", "goal"), FITTED_TO):
        files[name] = f"results/meshes/{wildcards.v}/{position}.vtu"
        files[f"{name}_fiducials"] = f"results/registration/{wildcards.v}/{position}_fiducials.csv"
    return files


def pair_gravity(wildcards):
    """Its directions in the scanner frames of the two positions."""
    return [gravity(wildcards.v, position) for position in FITTED_TO]


def held_out(volunteer):
    """The positions that no fit sees, of those that a volunteer was scanned in."""
    return [p for p in positions(volunteer) if p in VALIDATION["positions"] and p not in SEGMENTED]


def validated(volunteer):
    """Every position that a prediction is compared with: fitted, then held out."""
    return [*SEGMENTED, *held_out(volunteer)]


def pressed_by_all(wildcards, end):
    """A file of every strategy of one breast and set of moduli."""
    folder = f"results/compression/{wildcards.v}/{wildcards.side}"
    return [f"{folder}/{strategy}_{wildcards.moduli}{end}" for strategy in STRATEGIES]


def pressed_all_ways(end):
    """A file of every strategy, with every set of moduli, of every breast of the study."""
    ways = [(strategy, moduli) for moduli in MODULI for strategy in STRATEGIES]
    return [
        path
        for strategy, moduli in ways
        for path in over(f"results/compression/{{v}}/{{side}}/{strategy}_{moduli}{end}", side=COMPRESSION["sides"])
    ]


def xrayed(template):
    """A path for every breast and every strategy that is X-rayed."""
    return over(template, side=COMPRESSION["sides"], strategy=XRAY["strategies"])


def known_strategies(names, scenes, asked_by="the configuration"):
    """The strategies of that file by name, in the order asked for; refused when one is not there."""
    absent = [name for name in names if name not in scenes]
    if absent:
        raise WorkflowError(
            f"ConfigurationError: {asked_by}: no strategy {absent[0]!r}; choose one of: {', '.join(scenes)}"
        )
    return {name: scenes[name] for name in names}


def order_of(wildcards):
    """The draws of a volunteer in their order of stiffness."""
    return [f"results/propagation/{wildcards.v}/{wildcards.side}_order.csv"]


def propagated(template):
    """A path for every volunteer with a held-out position."""
    return [template.format(v=v) for v in WOMEN if held_out(v)]
