# The chain of one breast: what each of its rules reads, writes and is given comes from the table of its stages.
from mammosim.chain.files import chain_of, job_inputs, job_outputs, nearest_kept, seconds_file, variant_of
from mammosim.chain.graph import nested, overridden, pruned, read_by, upstream
from mammosim.chain.stages import STAGES

STRESS_FREE = config["mechanics"]["stress_free"]
OF_CHAIN = ("registration", "segmentation", "mesh", "morph", "mechanics", "effects", "compression", "xray")
EFFECTS = [*config["mechanics"]["effects"], *config["xray"]["effects"]]
PLACEHOLDERS = {name: f"{{{name}}}" for name in "v p side method strategy moduli position also".split()}


def places(wildcards):
    """The wildcards of the table's paths: those of a job, and of the study where it has none."""
    found = {"method": STRESS_FREE["default"], "also": "", **wildcards}
    if "v" not in found:
        return found
    found = {"p": modelled_in(found["v"]), "reference": reference_of(found["v"]), **found}
    given = VOLUNTEERS[found["v"], found["p"]]
    return found | {"strokes": given.strokes, "listed": given.fiducials, "given_labels": given.labels}


def label_settings(wildcards):
    """How a label map is read, and what explains its codes."""
    codes = VOLUNTEERS[wildcards["v"], places(wildcards)["p"]].codes if "v" in wildcards else ""
    return config["labels"] | {"codes": codes}


def load_of(wildcards):
    """How the breast of a job is loaded: the position, or the strategy that presses it."""
    load = {"position": wildcards["position"]} if "position" in wildcards else {}
    if "moduli" in wildcards:
        load |= {"moduli": wildcards["moduli"], "tissues": moduli_table(wildcards["moduli"])}
        load |= {"thickness_mm": COMPRESSION["thickness_mm"].get(wildcards["v"])}
    if "strategy" in wildcards:
        load |= {"strategy": WAYS[wildcards["strategy"]]}
    return load


@cache
def moduli_table(name):
    """The tissues of a set of moduli: the study's own, or those of a file of config/tissues."""
    return TISSUES if name == "gravity" else tissue_table(name)


def settings_of(wildcards):
    """Everything that the stages of the study may read in a job."""
    found = {name: config[name] for name in OF_CHAIN} | {"tissues": TISSUES, "load": load_of(wildcards)}
    found |= {"labels": label_settings(wildcards)}
    return overridden(found, {"mechanics": {"stress_free": {"default": places(wildcards)["method"]}}})


def subject_of(wildcards):
    """Whose breast a job is about."""
    if "v" not in wildcards:
        return {"side": "", "gravity": "", "streams": [config["seed"]]}
    v, p, side = wildcards["v"], places(wildcards)["p"], wildcards.get("side", "")
    seed = config["seed"]
    return {
        "side": side,
        "gravity": gravity(v, p),
        "streams": [seed, v, side],
        "scan": [seed, v, p],
        "moves": p != reference_of(v),
        "has": list(data_of(v).has(p)),
    }


def reasons_of(data, method=STRESS_FREE["default"]):
    """Each stage and question: why such data of a volunteer do not allow it, '' where they do."""
    wildcards = {"v": data.name, "side": "left", "strategy": "standard", "moduli": "gravity", "method": method}
    settings, effects = study_case(wildcards)
    subject = subject_of(wildcards) | {"moves": data.base != data.frame, "has": list(data.has(data.base))}
    return allowed.reasons(data, chain_of({"subject": subject, "settings": settings, "effects": effects}, {}))


@cache
def lacking(volunteer, method=STRESS_FREE["default"]):
    """Each stage and question: why her data do not allow it, '' where they do."""
    return reasons_of(data_of(volunteer), method)


def able(*asked):
    """The volunteers whose data allow all that is asked."""
    return [v for v in WOMEN if not any(lacking(v)[name] for name in asked)]


def meshed(volunteer):
    """The positions whose meshes the study shows; none where her data allow no mesh."""
    return segmented(volunteer) if volunteer in able("mesh") else []


def some_able(asked):
    """Those whose data allow it. Raises WorkflowError with the reasons where there is nobody."""
    if not (found := able(asked)):
        why = "; ".join(dict.fromkeys(lacking(v)[asked] for v in WOMEN))
        raise WorkflowError(f"ConfigurationError: {asked} cannot be computed: {why}")
    return found


def methods_of(volunteer):
    """The ways to the stress-free shape that her data allow."""
    return [method for method in STRESS_FREE["methods"] if not lacking(volunteer, method)["unloaded"]]


def in_common(volunteer, position):
    """Markers and nipples of a position in the frame of her model: as they are where nothing is registered."""
    if data_of(volunteer).apart:
        return f"results/fiducials/{volunteer}/{position}.csv"
    return f"results/registration/{volunteer}/{position}_fiducials.csv"


def unloaded_of(volunteer, methods):
    """Her shapes without gravity by these methods."""
    folder = f"results/mechanics/{volunteer}/stress_free"
    return [f"{folder}/{modelled_in(volunteer)}_{method}.vtu" for method in methods]


def stress_free_of(volunteer):
    """The stress-free shape that is pressed."""
    return f"results/mechanics/{volunteer}/stress_free/{modelled_in(volunteer)}.vtu"


def motion_of(volunteer, position):
    """The motion of a position into the frame of her model; none where nothing is registered."""
    return [] if data_of(volunteer).apart else f"results/registration/{volunteer}/{position}.tfm"


def study_case(wildcards):
    """Settings and effects of the study."""
    return settings_of(wildcards), EFFECTS


def case(products, wildcards):
    """Settings and effects of a job that makes these products: the study's, or those of a variant."""
    return variant_case(products[0], wildcards) if wildcards.get("also") else study_case(wildcards)


def job_given(products, wildcards, settings, effects):
    """Subject, settings and effects of a job, as far as they can change these products."""
    subject = subject_of(wildcards)
    chain = chain_of({"subject": subject, "settings": settings, "effects": effects}, {})
    used = dict.fromkeys(each for product in products for each in (*chain.upstream(product), product))
    acting = {effect for name in used for effect in STAGES[name].effects}
    return {
        "subject": subject,
        "settings": pruned(settings, [name for each in used for name in STAGES[each].reads]),
        "effects": [effect for effect in effects if effect in acting],
    }


def given(*products):
    """What a job that makes these products is given."""

    def of(wildcards):
        wildcards = dict(wildcards.items())
        return job_given(products, wildcards, *case(products, wildcards))

    return of


def reads(*products):
    """The files that a job reads to make these products."""

    def of(wildcards):
        wildcards = dict(wildcards.items())
        settings, effects = case(products, wildcards)
        chain = chain_of({"subject": subject_of(wildcards), "settings": settings, "effects": effects}, {})
        variant = wildcards.get("also", "")
        study = study_chain(wildcards) if variant else None
        return job_inputs(products, places(wildcards), chain, also=lambda name: variant_of(name, chain, study) if variant else "")

    return of


def given_labels_inputs(wildcards):
    """What labels that a person gave are read from; a folder of them is known by its files."""
    return {name: place_of(path) for name, path in reads("labels")(wildcards).items()}


def study_chain(wildcards):
    """The study's chain of the breast of a job."""
    settings, effects = study_case(wildcards)
    return chain_of({"subject": subject_of(wildcards), "settings": settings, "effects": effects}, {})


def measured(volunteer, *products):
    """The files of a volunteer's own measurements, and of what was labelled in them, for any job.

    Of what she has: those of another position only where hers is moved into its frame.
    """
    found = {}
    for name in (name for name in products if gives(volunteer, name)):
        found |= {f"{name}__{file}": path for file, path in STAGES[name].files.paths(places({"v": volunteer})).items()}
    return found


def gives(volunteer, name):
    """Whether her data give a product: those that bring a position into another's frame only where hers is moved."""
    moved = modelled_in(volunteer) != reference_of(volunteer)
    return not lacking(volunteer)[name] and (moved or not name.startswith(("transform", "reference_")))


def breast_of(volunteer, *more):
    """The files of what her breast is made of, and of more."""
    return measured(volunteer, "labels", "fiducials", "transform", *BOTH, *more)


def softening_given(volunteer, side):
    """The chain of a breast that is loaded upright, and pressed by the standard strategy."""
    wildcards = {"v": volunteer, "side": side, "position": "upright", "strategy": "standard", "moduli": "gravity"}
    return job_given(["loaded", "exposed_dose"], wildcards, *study_case(wildcards))


def propagated_given(volunteer, side):
    """The chain of a breast that is pressed by the standard strategy."""
    wildcards = {"v": volunteer, "side": side, "strategy": "standard", "moduli": "gravity"}
    return job_given(["exposed_dose"], wildcards, *study_case(wildcards))


BOTH = ["reference_mesh"] if "mean_start" in (STRESS_FREE["default"], f"{STRESS_FREE['start']}_start") else []


def writes(*products):
    """The files that a job writes, with the rule's wildcards."""
    return job_outputs(products, PLACEHOLDERS)


def runs(*products):
    """The parameters of a job that makes these products."""
    return {"products": list(products), "functions": [STAGES[name].function for name in products], "given": given(*products)}


wildcard_constraints:
    also="|-[0-9a-f]{8}",
