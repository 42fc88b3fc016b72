# Functions of the scenes: their files, settings and families, and the variants of the chain that they are.
import hashlib
import itertools
import json
from dataclasses import asdict

from mammosim.chain.quantities import QUANTITIES
from mammosim.chain.stages import MECHANICS as MECHANICS_OF
from mammosim.chain.stages import XRAY as XRAY_OF

BREAST_AND_LOAD = ("v", "side", "strategy", "moduli", "position")
STUDY = "study"  # the accuracy of the study's own settings
PRESETS = sorted(p.stem for p in (HOME / "config/accuracy").glob("*.yaml") if not p.stem.startswith("parameters"))


def known_scene(name):
    """The scene of config/scenes/{name}.yaml, with what it leaves to the study; rejected if it asks for what cannot be."""
    file = f"config/scenes/{name}.yaml"
    given = checked(read_yaml(file), "scene", [file], known=KNOWN)
    values = {"volunteer": WOMEN[0], "side": COMPRESSION["sides"][0], "accuracy": SCREENING["accuracy"]} | given
    try:
        scene = Scene.of(name, values)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None
    known = sorted({volunteer for volunteer, _ in VOLUNTEERS})
    if scene.volunteer not in known:
        raise WorkflowError(f"ConfigurationError: {file}: no volunteer {scene.volunteer!r}; choose one of: {', '.join(known)}")
    return scene


def family_of(scene):
    """The name of all scenes with the same breast, tissues and load."""
    same = {"volunteer": scene.volunteer, "side": scene.side, "tissues": scene.tissues, "load": scene.load.stated}
    digest = hashlib.sha256(json.dumps(same, sort_keys=True).encode()).hexdigest()[:8]
    return f"{scene.volunteer}_{scene.side}_{digest}"


def scenes_of_family(family):
    """Names of its scenes whose effects are to be found."""
    return [name for name in SCENES if FAMILY[name] == family and SCENES[name].effects is None]


def families_to_screen():
    """Families in which a scene leaves its effects to be found."""
    return sorted({FAMILY[name] for name, scene in SCENES.items() if scene.effects is None})


def screening_given(wildcards):
    """Subject and settings of the chain of all scenes of a family, on the coarse model."""
    names = scenes_of_family(wildcards.family)
    asked = [quantity for name in names for quantity in SCENES[name].asked]
    return job_given(products_of(asked), scene_places(names[0]), scene_settings(names[0], SCREENING["coarse"]), [])


def volunteer_of_family(family):
    """Whose breast it is."""
    return next(scene.volunteer for name, scene in SCENES.items() if FAMILY[name] == family)


@cache
def measured_accuracy():
    """The measured curves that presets and scenes are chosen from."""
    from mammosim.io.tables import read_commented  # only where a scene states errors: this takes a second

    return read_commented(home("config/accuracy/measured.csv"))


@cache
def picked(accuracy):
    """The cheapest settings that meet errors (JSON, quantity -> error) by the measured curves; says which."""
    from mammosim.study.accuracy.presets import as_imaged, chosen

    choice = chosen(as_imaged(measured_accuracy()), json.loads(accuracy))
    if workflow.is_main_process:
        settings = ", ".join(f"{name} {value}" for name, value in choice.settings.items())
        errors = ", ".join(f"{name} {error:.2g}" for name, error in choice.errors.items())
        logger.info(f"accuracy {accuracy} is met by {settings}: {errors}, {choice.seconds:.0f} s")
    return choice


def preset(accuracy):
    """The overrides of config/accuracy/{accuracy}.yaml, or the cheapest settings that meet its errors; of the study none."""
    if accuracy == STUDY:
        return {}
    if isinstance(accuracy, dict):
        try:
            return nested(picked(json.dumps(accuracy)).settings)
        except ConfigurationError as error:
            raise WorkflowError(f"ConfigurationError: {error}") from None
    if accuracy not in PRESETS:
        raise WorkflowError(f"ConfigurationError: no preset {accuracy!r}; choose one of: {', '.join([STUDY, *PRESETS])}")
    return preset_of(accuracy)


@cache
def preset_of(accuracy):
    """The overrides of config/accuracy/{accuracy}.yaml, which has some."""
    file = f"config/accuracy/{accuracy}.yaml"
    values = read_yaml(file)
    if not values:
        raise WorkflowError(
            f"ConfigurationError: {file} is empty, since nothing met its limits when it was "
            f"chosen; allow more in {config['accuracy']} and renew it"
        )
    return checked_overrides(values, file)


def accuracy_words(name):
    """The accuracy of a scene: its preset, or what was picked for the errors that it states."""
    scene = SCENES[name]
    if scene.errors is None:
        return scene.accuracy
    choice = picked(json.dumps(scene.errors))
    return ", ".join(f"{name} {value}" for name, value in choice.settings.items())


def scene_places(name):
    """The wildcards of a scene's breast and load."""
    scene = SCENES[name]
    moduli = "gravity" if scene.tissues == config["tissues"] else scene.tissues
    return {"v": scene.volunteer, "side": scene.side, "moduli": moduli} | scene.load.stated


@cache
def scene_settings(name, accuracy=None):
    """What the chain of a scene reads, at its own accuracy or at that of a preset."""
    scene, places = SCENES[name], scene_places(name)
    if scene.load.strategy is not None:
        known_strategies([scene.load.strategy], WAYS, f"config/scenes/{name}.yaml")
    settings = settings_of(places) | {"tissues": tissue_table(scene.tissues)}
    # Whatever tissues it has, its pressures are those of the study's own moduli.
    settings = overridden(settings, {"load": {"moduli": "gravity"}})
    # What the images were labelled with is the study's.
    labelled = ("registration", "segmentation")
    others = {k: v for k, v in preset(accuracy or scene.wanted).items() if k in settings and k not in labelled}
    return overridden(settings, others)


def question(scene):
    """A scene as the plain values of a job."""
    return asdict(SCENES[scene])


def to_screen(scene):
    """What its screening depends on."""
    return {name: value for name, value in question(scene).items() if name not in ("accuracy", "errors")}


def scene_effects(scene, model):
    """The effects of a model of a scene; of a screened one they are known once the checkpoint was passed."""
    found = None
    if model == "screened" and SCENES[scene].effects is None:
        found = read_plain(checkpoints.screen.get(family=FAMILY[scene]).output.effects)
    return SCENES[scene].modelled(model, found)


def screening_of(wildcards):
    """The screening that a scene's model depends on, if any."""
    found = effects_or_file(wildcards.scene)
    return [found] if wildcards.model == "screened" and isinstance(found, str) else []


def effects_or_file(scene):
    """The effects that a scene lists, or the file in which they are found."""
    listed = SCENES[scene].effects
    return f"results/scenes/screening/{FAMILY[scene]}.csv" if listed is None else list(listed)


def scene_chain(scene, effects):
    """The chain of a scene with these effects."""
    settings, places = scene_settings(scene), scene_places(scene)
    return chain_of({"subject": subject_of(places), "settings": settings, "effects": effects}, {})


def known_effects(scene, model):
    """The effects of a model of a scene; None of a screened one that was not screened yet."""
    found = effects_or_file(scene)
    if model == "screened" and isinstance(found, str):
        rows = read_plain(found) if Path(found).exists() else []
        # A scene that is new in its family waits for the next screening.
        return SCENES[scene].modelled(model, rows) if any(each["scene"] == scene for each in rows) else None
    return SCENES[scene].modelled(model, None)


def variant_case(product, wildcards):
    """Settings and effects of the variant by whose name a product is asked for."""
    for scene, model in itertools.product(SCENES, ("screened", "full")):
        at = scene_places(scene)
        same = all(at.get(name) == value for name, value in wildcards.items() if name in BREAST_AND_LOAD)
        effects = known_effects(scene, model) if same else None
        if effects is not None and asked_variant(scene, effects, product) == wildcards["also"]:
            return scene_settings(scene), sorted(effects)
    raise WorkflowError(
        f"no scene has a variant {wildcards['also']} of {product}; results/variants.tsv lists those of the last run"
    )


def asked_variant(scene, effects, product):
    """What a product of a scene is called beside the study's."""
    return variant_of(product, scene_chain(scene, effects), study_chain(scene_places(scene)))


def kept_of(scene, effects):
    """The kept products that a scene's answer is taken from, and all that those are made of, as they are called."""
    chain = scene_chain(scene, effects)
    asked = [each for name in SCENES[scene].asked for each in QUANTITIES[name].products]
    ends = {name for each in asked for name in ([each] if STAGES[each].files else nearest_kept([each], chain))}
    used = {name for end in ends for name in (*chain.upstream(end), end) if name in {**MECHANICS_OF, **XRAY_OF}}
    return ends, {name: asked_variant(scene, effects, name) for name in used if STAGES[name].files}


def answer_inputs(wildcards):
    """The files that a scene's answer is taken from, and those that say what they took."""
    scene = wildcards.scene
    ends, called = kept_of(scene, scene_effects(scene, wildcards.model))
    where = places(scene_places(scene))
    paths = {}
    for name in {*ends, "mesh"}:
        files = STAGES[name].files.paths(where | {"also": called[name]})
        paths |= {f"{name}__{file}": path for file, path in files.items()}
    return paths | {"took": [seconds_file(name, where | {"also": also}) for name, also in called.items()]}


def all_variants():
    """What each variant of the chain is: product, its name, and the scenes and models that ask for it."""
    found = {}
    for scene, model in itertools.product(SCENES, ("screened", "full")):
        effects = known_effects(scene, model)
        called = {} if effects is None else kept_of(scene, effects)[1]
        for name, also in called.items():
            if also:
                path = STAGES[name].files.stem.format(**places(scene_places(scene)) | {"also": also})
                found.setdefault(path, []).append(f"{scene} ({model}, accuracy {accuracy_words(scene)})")
    return found
