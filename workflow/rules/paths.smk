# Paths and parameters that several rules begin with.


def known_strategies(names, scenes, asked_by="the configuration"):
    """The strategies of that file by name, in the order asked for; rejected when one is not there."""
    absent = [name for name in names if name not in scenes]
    if absent:
        raise WorkflowError(
            f"ConfigurationError: {asked_by}: no strategy {absent[0]!r}; choose one of: {', '.join(scenes)}"
        )
    return {name: scenes[name] for name in names}


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
        for path in over(f"results/compression/{{v}}/{{side}}/{strategy}_{moduli}{end}", able("pressed"), side=COMPRESSION["sides"])
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
