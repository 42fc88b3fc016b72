# Paths and parameters that several rules begin with.
from mammosim.chain.conditions import is_flat
from mammosim.core.errors import MammosimError


def known_strategies(names, scenes, asked_by="the configuration"):
    """The strategies of that file by name, in the order asked for; rejected when one is not there."""
    absent = [name for name in names if name not in scenes]
    if absent:
        raise WorkflowError(f"ConfigurationError: {asked_by}: no strategy {absent[0]!r}; choose one of: {', '.join(scenes)}")
    return {name: scenes[name] for name in names}


def with_plates(ways, file):
    """The strategies; that the plates they describe can be is checked, and what surfaces they name is known by content."""
    if all(is_flat(way) for way in ways.values()):
        return ways
    # What is needed for plates takes a second to load, which few strategies ask for.
    from mammosim.chain import paddles, plates, strategies
    from mammosim.core.settings import read

    try:
        ways = {name: paddles.known_by_content(way, home, at=f"{file}: {name}") for name, way in ways.items()}
        size = read(plates.PlateSize, config["compression"]["plate_mm"], "compression.plate_mm")
        for name, way in ways.items():
            at = f"{file}: {name}"
            strategies.Strategy.read(way, at=at).require_possible(size, at=at)
    except MammosimError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    return ways


def imaging_systems():
    """Rows of the table of systems by name, None where one has a gap."""
    rows = read_plain(PACKAGE / "io" / "data" / "imaging_systems.csv")
    return {row["system"]: {key: value or None for key, value in row.items()} for row in rows}


def scored_of(volunteer, what):
    """The score of a digital volunteer, none of a real one."""
    return [f"results/scores/{volunteer}/{what}.csv"] if volunteer in DIGITAL_WOMEN else []


def all_of_her_checked(wildcards):
    """That all that is given of her is usable, before any of it is used."""
    return [f"results/checked/{wildcards.v}_{p}.csv" for p in positions(wildcards.v)]


def pair_inputs(wildcards):
    """Meshes, fiducials and transforms of the two positions, and how sure the registration is."""
    registered = f"results/registration/{wildcards.v}/prone"
    files = {"start_transform": f"{registered}.tfm", "start_steps": f"{registered}_steps.csv"}
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
    return [*segmented(volunteer), *held_out(volunteer)]


def order_of(wildcards):
    """The draws of a volunteer in their order of stiffness."""
    return [f"results/propagation/{wildcards.v}/{wildcards.side}_order.csv"]


def propagated(template):
    """A path for every volunteer with a held-out position."""
    return [template.format(v=v) for v in able("propagation")]


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
        for path in over(
            f"results/compression/{{v}}/{{side}}/{strategy}_{moduli}{end}", able("pressed"), side=COMPRESSION["sides"]
        )
    ]


def xrayed(template):
    """A path for every breast and every strategy that is X-rayed."""
    return over(template, able("pressed"), side=COMPRESSION["sides"], strategy=XRAY["strategies"])


def asked_settings():
    """The words by which this run was given its settings, for another one."""
    given = workflow.config_settings
    files = [str(Path(file).resolve()) for file in given.configfiles]
    values = given.config_args
    return [*(["--configfile", *files] if files else []), *(["--config", *values] if values else [])]


def given_rows(volunteer):
    """What a page of a volunteer is told of each position that she has: whether it is used, its files, its gravity.

    there: the scans of a digital volunteer are made by the study, which a look at them does not wait for.
    """
    rows = {p: row for (v, p), row in VOLUNTEERS.items() if v == volunteer}
    return [
        {
            "position": p,
            "used": p in positions(volunteer),
            "there": volunteer not in DIGITAL or Path(row.images).exists(),
            "files": {kind: path for kind, path in given_files(row).items() if path},
            "gravity": row.gravity,
            "how": series_of(row),
            "codes": config["labels"] | {"codes": row.codes},
        }
        for p, row in rows.items()
    ]


def given_files(row):
    """The files of a row of the volunteer table, as check_input calls them."""
    return {"images": row.images, "labels": row.labels, "listed": row.fiducials, "strokes": row.strokes}


def measured_paths(volunteer):
    """All files that a volunteer of one's own has; none of a digital one, whose scans the study makes."""
    rows = [] if volunteer in DIGITAL else given_rows(volunteer)
    return [path for row in rows for path in row["files"].values()]


def told_of(volunteer):
    """What her data allow, what more would add, and to what thickness she is pressed, in words."""
    return {
        "planned": allowed.told(lacking(volunteer)),
        "gains": allowed.gains(data_of(volunteer), reasons_of),
        "thickness": thickness_words(volunteer),
    }


def thickness_words(volunteer):
    """To what thickness the standard strategy presses her."""
    stated, share = COMPRESSION["thickness_mm"].get(volunteer), COMPRESSION["depth_share"]
    if stated is not None:
        return f"Her standard compression is to {stated:g} mm, as given."
    return (
        f"No thickness is given for her: her standard compression is to {share:g} of the depth of each breast in prone, "
        "from the ribs to the nipple (`compression.depth_share`). State hers in `compression.thickness_mm` if it is known."
    )


def viewed(volunteer):
    """The bodies that are shown of a woman: group and name in words, kind and path."""
    predicted = validated(volunteer) if volunteer in able("validation") else []
    measured = [*meshed(volunteer), *(p for p in predicted if p not in meshed(volunteer))]
    base = modelled_in(volunteer) if volunteer in able("stress_free") else None
    skin = min(UPRIGHT["skin_kpa"], key=lambda kpa: abs(kpa - TISSUES["skin"]["youngs_modulus_kpa"]))
    shapes = [
        *(("measured", p, "mesh", f"results/meshes/{volunteer}/{p}.vtu") for p in measured),
        *([("computed", f"without gravity, from {base}", "mesh", stress_free_of(volunteer))] if base else []),
        *(("predicted by the fit", p, "mesh", f"results/validation/{volunteer}/{p}.vtu") for p in predicted if p != base),
        *(
            ("computed", f"upright, skin of {kpa} kPa", "predicted", f"results/mechanics/{volunteer}/upright/skin_{kpa}kpa.vtu")
            for kpa in ([skin] if volunteer in able("upright") else [])
        ),
        *(
            (
                f"{side} breast pressed, {moduli} moduli",
                strategy,
                "pressed",
                f"results/compression/{volunteer}/{side}/{strategy}_{moduli}.vtu",
            )
            for side in (COMPRESSION["sides"] if volunteer in able("pressed") else [])
            for moduli in MODULI
            for strategy in STRATEGIES
        ),
    ]
    keys = ("group", "name", "kind", "path")
    return [{key: value.replace("_", " ") if key == "name" else value for key, value in zip(keys, each)} for each in shapes]


def absent_words(volunteer):
    """What cannot be shown of a woman and why, and what more of her data would add."""
    gains = [
        f"With {' and '.join(names)} there would also be: {', '.join(whats)}." for names, whats in told_of(volunteer)["gains"]
    ]
    return [*(f"{what} is not planned: {why}." for what, why in NOT_PLANNED[volunteer]), *gains]


def files_viewed(body):
    """The files of a body that is shown."""
    more = [body["path"].replace(".vtu", "_faces.csv")] if body["kind"] == "pressed" else []
    return [body["path"], *more]


def tables_of(volunteer):
    """The files of her rows of the study's tables, by table."""
    found = {name: [path for path in TABLES[name] if f"/{volunteer}/" in path] for name in HER_TABLES}
    return {name: paths for name, paths in found.items() if paths}


def pictures_of(volunteer):
    """Her figures of the study, but for those that wait for other women."""
    alone = [name for name, (_, files) in PICTURED.items() if not any("results/study/" in str(each) for each in files.values())]
    hers = [re.escape(name.replace("{v}", "\0")).replace("\0", volunteer) for name in alone if "{v}" in name]
    pattern = re.compile("|".join(re.sub(r"\\\{\w+\\\}", "(?:PLACE)", each) for each in hers).replace("PLACE", HER_PLACES))
    return [f"results/study/figures/{name}.png" for name in PICTURES if pattern.fullmatch(name)]


# What her page shows and links of the study's tables.
HER_TABLES = [
    *(
        "registration",
        "mesh_quality",
        "stress_free",
        "stress_free_attempts",
        "identification",
        "fit",
        "validation",
        "propagation",
    ),
    *("compression", "field", "conservation", "dose", "slices", "image"),
]
HER_PLACES = "|".join([*GRAVITY, "left", "right", "gravity", "compression"])
