# Whom the study is about: the table of volunteers, the digital volunteers, and paths for all of them.
from types import SimpleNamespace

from mammosim.chain import allowed
from mammosim.core.positions import GRAVITY
from mammosim.io.label_codes import is_preset
from mammosim.io.parts import heads, parts, recorded


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

    A digital volunteer who has no row there gets hers: where the rules that make her put her scans.
    """
    given = [row for row in rows_of(file, DIGITAL) if row["volunteer"] in WOMEN]
    made = [w for w in DIGITAL if w not in {row["volunteer"] for row in given}]
    rows = [*given, *(digital_row(w, p) for w in made for p in scanned_positions(w))]
    try:
        configuration.check_volunteers(rows, file=file, there=is_there, digital=DIGITAL)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return {
        (row["volunteer"], row["position"]): SimpleNamespace(**{name: row.get(name) or "" for name in configuration.COLUMNS})
        for row in rows
    }


def left_out(file):
    """Whom the settings name, and whose files are not there: none, unless `skip_absent` says so; never all."""
    named = config["volunteers"] if config["skip_absent"] else []
    found = configuration.absent((row for row in rows_of(file, DIGITAL) if row["volunteer"] in named), there=is_there)
    if found and len(found) == len(named):
        raise WorkflowError(
            f"ConfigurationError: {file}: nobody's data are there: {'; '.join(f'{v}: no {what}' for v, what in found.items())}; "
            "config/README.md says where to get data, and where they are looked for"
        )
    return found


def is_there(path):
    """Whether a path of the table is there, or the study may make it."""
    made = tuple(f"results/raw/{woman}/" for woman in DIGITAL)
    return Path(path).exists() or (path.startswith("results/") and (path.startswith(made) or "/raw/" not in path))


def scanned_positions(woman):
    """The positions that a digital volunteer is scanned in."""
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
def data_of(volunteer):
    """What is given of a volunteer."""
    given = {
        p: frozenset(what for what in HER_DATA if getattr(row, what)) for (v, p), row in VOLUNTEERS.items() if v == volunteer
    }
    held_out = [p for p in config["validation"]["positions"] if p not in config["segmentation"]["positions"]]
    modelled = config["mechanics"]["stress_free"]["position"]
    stated = volunteer in config["compression"]["thickness_mm"]
    return allowed.Data(volunteer, given, modelled, config["reference_position"], tuple(held_out), stated)


def series_of(row):
    """Which series of a row's images is meant, and whether its gaps are interpolated."""
    return {"series": row.series, "gaps": row.gaps}


def positions(volunteer):
    """The positions of a volunteer that anything is made of: all that can be brought into one frame."""
    return list(data_of(volunteer).used)


def modelled_in(volunteer):
    """The position that a volunteer's model is made of."""
    return data_of(volunteer).base


def reference_of(volunteer):
    """The position in whose frame her model is."""
    return data_of(volunteer).frame


def segmented(volunteer):
    """The positions that are labelled for more than the validation."""
    return [p for p in config["segmentation"]["positions"] if p in positions(volunteer)]


HER_DATA = (allowed.IMAGES, allowed.LABELS, allowed.STROKES, allowed.FIDUCIALS)
RECOVERY = checked(read_yaml(config["recovery"]), "recovery", [config["recovery"]], known=KNOWN)
MADE = {f"made_{seed:02d}": seed for seed in RECOVERY["seeds"]}  # volunteer -> seed, on demand
DIGITAL = [*config["digital"]["women"], *MADE]
LEFT_OUT = left_out(config["volunteer_table"])
WOMEN = [v for v in config["volunteers"] if v not in LEFT_OUT]
VOLUNTEERS = volunteer_table(config["volunteer_table"])
TISSUES = tissue_table(config["tissues"])
DIGITAL_WOMEN = [v for v in WOMEN if v in config["digital"]["women"]]
LABELLED = [v for v in dict.fromkeys(v for v, _ in VOLUNTEERS) if allowed.LABELS in data_of(v).given[modelled_in(v)]]
REFERENCE = config["reference_position"]


def moving(volunteer):
    """The positions that are moved into the reference position's frame."""
    return [position for position in positions(volunteer) if position != reference_of(volunteer)]


def one_of(volunteers):
    """The pattern of a wildcard that is one of these; of none where there is none."""
    return "|".join(volunteers) or "(?!)"


def others_than(volunteers):
    """The pattern of a wildcard that is any volunteer but these."""
    return f"(?!(?:{one_of(volunteers)})/)[a-z0-9_]+"


def imaged(volunteer):
    """The positions of which there is an image."""
    return [p for p in positions(volunteer) if VOLUNTEERS[volunteer, p].images]


def scanned(template, which=positions):
    """A path for every volunteer and position."""
    return [template.format(v=v, p=p) for v in WOMEN for p in which(v)]


def scored(template, which):
    """A path for every digital volunteer and each of `which(volunteer)`."""
    return [template.format(v=v, p=p) for v in DIGITAL_WOMEN for p in which(v)]


def over(template, women=WOMEN, **values):
    """A path for every volunteer, or some of them, and every combination of the values."""
    return expand(template, v=women, **values)


def row(wildcards):
    """The line of the volunteer table."""
    return VOLUNTEERS[wildcards.v, wildcards.p]


@cache
def files_of(path):
    """The files that a path of the table stands for, as far as they can be recorded; none of what the study makes itself."""
    return recorded(given_parts(path))


def given_parts(path):
    """All files that a path of the table stands for; none of what the study makes itself."""
    return [] if path.startswith("results/") else parts(path)


def place_of(path):
    """A path of the table as an input. The date of a folder says nothing: that of each of its files does."""
    return ancient(path) if path and Path(path).is_dir() and not path.startswith("results/") else path or []


@cache
def content_of(*paths):
    """A digest by which these files are known, whatever their dates."""
    return heads(file for path in paths for file in given_parts(path))


def codes_file(wildcards):
    """The file that explains the codes of her labels; none where a preset does, or nothing has to."""
    codes = row(wildcards).codes
    return [] if is_preset(codes) or not codes else codes


def gravity(volunteer, position):
    """Its direction in the scanner frame of that position, 'x y z'."""
    return VOLUNTEERS[volunteer, position].gravity
