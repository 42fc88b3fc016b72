# Whom the study is about: the table of volunteers, the digital women, and paths for all of them.
from types import SimpleNamespace

from mammosim.core.positions import GRAVITY
from mammosim.io.plain import read_plain


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


def positions(volunteer):
    """The positions that a volunteer was scanned in."""
    return [position for name, position in VOLUNTEERS if name == volunteer]


RECOVERY = checked(read_yaml(config["recovery"]), "recovery", [config["recovery"]], known=KNOWN)
MADE = {f"made_{seed:02d}": seed for seed in RECOVERY["seeds"]}  # volunteer -> seed, on demand
DIGITAL = [*config["digital"]["women"], *MADE]
VOLUNTEERS = volunteer_table(config["volunteer_table"])
TISSUES = tissue_table(config["tissues"])
WOMEN = list(config["volunteers"])
DIGITAL_WOMEN = [v for v in WOMEN if v in config["digital"]["women"]]
REFERENCE = config["reference_position"]


def moving(volunteer):
    """The positions that are moved into the reference position's frame."""
    return [position for position in positions(volunteer) if position != REFERENCE]


def scanned(template, which=positions):
    """A path for every volunteer and position."""
    return [template.format(v=v, p=p) for v in WOMEN for p in which(v)]


def scored(template, which):
    """A path for every digital volunteer and each of `which(volunteer)`."""
    return [template.format(v=v, p=p) for v in DIGITAL_WOMEN for p in which(v)]


def over(template, **values):
    """A path for every volunteer and every combination of the values."""
    return expand(template, v=WOMEN, **values)


def row(wildcards):
    """The line of the volunteer table."""
    return VOLUNTEERS[wildcards.v, wildcards.p]


def gravity(volunteer, position):
    """Its direction in the scanner frame of that position, 'x y z'."""
    return VOLUNTEERS[volunteer, position].gravity
