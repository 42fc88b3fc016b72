# Functions of the published models: their files, their chains, and which products of the study these begin with.
from mammosim.chain.graph import Chain
from mammosim.chain.published_stages import shared
from mammosim.chain.subject import Subject
from mammosim.io.plain import repeated
from mammosim.study.models.model import PRODUCTS, Model

SOURCE_KEYS = re.findall(r"^@\w+\{([^,\s]+),", Path(home("config/references.bib")).read_text(encoding="utf-8"), re.MULTILINE)
# Products whose time in the study counts as the model's: it would have taken it, too.
COUNTED = ("unloaded", "standard_path")


def known_model(name):
    """The model of config/models/{name}.yaml; rejected if it names a law, effect or source that is not known."""
    file = f"config/models/{name}.yaml"
    values = checked(read_yaml(file), "model", [file])
    tissues = values["tissues"]
    if isinstance(tissues, str):
        if tissues not in (known := stems("config/tissues")):
            listed = ", ".join(known)
            raise WorkflowError(
                f"ConfigurationError: {file}: tissues = {tissues!r}: not in config/tissues; take one of: {listed}"
            )
        tissues = tissue_table(tissues)
    try:
        inline = {"type": "object", "properties": {"tissues": schema_of("tissues")}}
        configuration.check_settings({"tissues": tissues}, inline, files=[file])
        configuration.check_tissues(tissues["tissues"], ["adipose", "glandular", "muscle"], file=file)
        model = Model.of(name, values | {"tissues": tissues})
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    if model.source not in SOURCE_KEYS:
        raise WorkflowError(
            f"ConfigurationError: {file}: source = {model.source!r}: config/references.bib has no such key; add the publication"
        )
    return model


def known_models(names):
    """The models by name, each with a title of its own, by which page and figure call it."""
    found = {name: known_model(name) for name in names}
    if twice := repeated([model.title for model in found.values()]):
        whose = " and ".join(f"config/models/{name}.yaml" for name, model in found.items() if model.title == twice[0])
        raise WorkflowError(f"ConfigurationError: {whose} have the same title, {twice[0]!r}; change one")
    return found


def model_places(wildcards):
    """The wildcards of a model's breast, pressed by the standard strategy."""
    return {"v": wildcards.v, "side": wildcards.side, "strategy": "standard", "moduli": "gravity"}


def model_settings(wildcards):
    """What its chain may read."""
    where = model_places(wildcards)
    return MODELS[wildcards.published].over(settings_of(where), modelled_in(wildcards.v))


def model_chain(wildcards):
    """Its chain."""
    model = MODELS[wildcards.published]
    subject = Subject.of(subject_of(model_places(wildcards)))
    return Chain(subject, model_settings(wildcards), frozenset(model.effects), model.stages)


def model_shared(wildcards):
    """The products of the study that it begins with."""
    where = model_places(wildcards) | {"method": MODELS[wildcards.published].method}
    return shared(PRODUCTS, model_chain(wildcards), study_chain(where))


def model_paths(wildcards):
    """The wildcards of the files of those products."""
    return places(model_places(wildcards) | {"method": MODELS[wildcards.published].method})


def model_inputs(wildcards):
    """Those products, the mesh, and where the nipple was measured in each position."""
    where = model_paths(wildcards)
    names = dict.fromkeys((*model_shared(wildcards), "mesh", "labels", "fiducials", "transform"))
    found = {}
    for name in (name for name in names if gives(wildcards.v, name)):
        found |= {f"{name}__{file}": path for file, path in STAGES[name].files.paths(where).items()}
    for position in model_positions(wildcards):
        found[f"nipples_{position}"] = in_common(wildcards.v, position)
    return found | {"took": [seconds_file(name, where) for name in model_shared(wildcards) if name in COUNTED]}


def model_positions(wildcards):
    """Positions of a model in which the woman was scanned."""
    return [position for position in ("prone", "supine") if position in positions(wildcards.v)]


def model_given(wildcards):
    """Subject, settings and effects of its chain, as far as they can change its products."""
    model = MODELS[wildcards.published]
    read = read_by(model.stages, PRODUCTS)
    return {
        "subject": subject_of(model_places(wildcards)),
        "settings": pruned(model_settings(wildcards), read),
        "effects": sorted(model.effects),
    }
