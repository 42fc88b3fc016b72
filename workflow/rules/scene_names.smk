# Functions of the scenes: their files, settings and families, and what each of their jobs begins with.
import hashlib
import json

from mammosim.io.tables import read_commented
from mammosim.chain.graph import nested, overridden, pruned, read_by
from mammosim.study.accuracy.presets import as_imaged, chosen

STUDY = "study"  # the accuracy of the study's own settings
PRESETS = sorted(p.stem for p in (HOME / "config/accuracy").glob("*.yaml") if not p.stem.startswith("knobs"))


def scene_values(name):
    """The values of config/scenes/{name}.yaml, with the volunteer, side and accuracy that it leaves to the study."""
    file = f"config/scenes/{name}.yaml"
    values = checked(read_yaml(file), "scene", [file])
    values = {"volunteer": WOMEN[0], "side": COMPRESSION["sides"][0], "accuracy": SCREENING["accuracy"]} | values
    known = sorted({volunteer for volunteer, _ in VOLUNTEERS})
    if values["volunteer"] not in known:
        raise WorkflowError(
            f"ConfigurationError: {file}: no volunteer {values['volunteer']!r}; choose one of: {', '.join(known)}"
        )
    return values


def known_scene(name, values):
    """The scene, refused with advice when it asks for what cannot be."""
    try:
        return Scene.of(name, values)
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None


def family_of(values):
    """The name of all scenes with the same breast, tissues and load."""
    same = {key: values[key] for key in ("volunteer", "side", "tissues", "load")}
    digest = hashlib.sha256(json.dumps(same, sort_keys=True).encode()).hexdigest()[:8]
    return f"{values['volunteer']}_{values['side']}_{digest}"


def scenes_of_family(family):
    """Names of its scenes whose effects are to be found."""
    return [name for name in SCENES if FAMILY[name] == family and SCENES[name].effects == "auto"]


def families_to_screen():
    """Families in which a scene leaves its effects to be found."""
    return sorted({FAMILY[name] for name, scene in SCENES.items() if scene.effects == "auto"})


def screening_settings(family):
    """What the chain of all scenes of a family reads on the coarse model."""
    names = scenes_of_family(family)
    asked = [quantity for name in names for quantity in SCENES[name].asked]
    return scene_settings(names[0], products_of(asked), SCREENING["coarse"])


def made_settings(wildcards, part):
    """What a part of a scene, and what it is made of, reads."""
    return scene_settings(made_for(wildcards.made)[0], PARTS[part])


def volunteer_of_family(family):
    """Whose breast it is."""
    return next(values["volunteer"] for name, values in SCENE_VALUES.items() if FAMILY[name] == family)


@cache
def measured_accuracy():
    """The measured curves that presets and scenes are chosen from."""
    return read_commented(home("config/accuracy/measured.csv"))


@cache
def picked(accuracy):
    """The cheapest settings that meet errors (JSON, quantity -> error) by the measured curves; says which."""
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
    values = read_yaml(f"config/accuracy/{accuracy}.yaml")
    if not values:
        raise WorkflowError(
            f"ConfigurationError: config/accuracy/{accuracy}.yaml is empty, since nothing met its limits when it was "
            f"chosen; allow more in {config['accuracy']} and renew it"
        )
    return values


def accuracy_words(name):
    """The accuracy of a scene: its preset, or what was picked for the errors that it states."""
    accuracy = SCENES[name].accuracy
    if not isinstance(accuracy, dict):
        return accuracy
    choice = picked(json.dumps(accuracy))
    return ", ".join(f"{name} {value}" for name, value in choice.settings.items())


def scene_settings(name, products, accuracy=None):
    """What products of a scene's chain read, at its own accuracy or another one: a preset, or errors asked for."""
    values, accuracy = SCENE_VALUES[name], accuracy or SCENES[name].accuracy
    load = {**values["load"]}
    if "strategy" in load:
        known_strategies([load["strategy"]], WAYS, f"config/scenes/{name}.yaml")
        load |= {"strategy": WAYS[load["strategy"]], "thickness_mm": thickness_of(name, values["volunteer"])}
    settings = chain_settings(tissue_table(values["tissues"]), load)
    # What the images were labelled with is the study's.
    others = {k: v for k, v in preset(accuracy).items() if k in settings}
    return pruned(overridden(settings, others), read_by(PRODUCTS, products))


def thickness_of(scene, volunteer):
    """To which thickness the standard strategy presses her."""
    known = COMPRESSION["thickness_mm"]
    if volunteer not in known:
        raise WorkflowError(
            f"ConfigurationError: scene {scene}: {volunteer} has no thickness to be pressed to; "
            "add her to compression.thickness_mm, or ask for a position only"
        )
    return known[volunteer]


def whose(scene):
    """The breast of a scene, which is all that its parts know of its file."""
    return {name: SCENE_VALUES[scene][name] for name in ("volunteer", "side")}


def question(scene):
    """What a scene asks, without its words."""
    return {name: value for name, value in SCENE_VALUES[scene].items() if name != "title"}


def to_screen(scene):
    """What its screening depends on."""
    return {name: value for name, value in question(scene).items() if name != "accuracy"}


def scene_effects(scene, model):
    """The effects of a model of a scene; of a screened one they are known once the checkpoint was passed."""
    found = None
    if model == "screened" and SCENES[scene].effects == "auto":
        found = pd.read_csv(checkpoints.screen.get(family=FAMILY[scene]).output.effects)
    return SCENES[scene].modelled(model, found)


def screening_of(wildcards):
    """The screening that a scene's model depends on, if any."""
    found = effects_or_file(wildcards.scene)
    return [found] if wildcards.model == "screened" and isinstance(found, str) else []


def effects_or_file(scene):
    """The effects that a scene lists, or the file in which they are found."""
    auto = SCENES[scene].effects == "auto"
    return f"results/scenes/screening/{FAMILY[scene]}.csv" if auto else list(SCENES[scene].effects)


def made_key(scene, effects, part):
    """Under which name a part is kept, that of its scenes' breast, load and accuracy, and its effects."""
    acting = effects_on(each for name in PARTS[part] for each in (*upstream(PRODUCTS, name), name)) & set(effects)
    return ".".join([GROUP[scene], *sorted(acting)])


def made_for(key):
    """A scene, and the effects, that a part of this name belongs to."""
    group, *effects = key.split(".")
    return next(scene for scene in SCENES if GROUP[scene] == group), effects


def group_of(scene):
    """The name of all scenes with the same family and accuracy."""
    accuracy = json.dumps(SCENES[scene].accuracy, sort_keys=True)
    return f"{FAMILY[scene]}_{hashlib.sha256(accuracy.encode()).hexdigest()[:6]}"


def scene_parts(scene, effects, products):
    """The parts, and their names, in which these products are kept; none of scatter that is not there."""
    kept = {name for name in products if name != "scatter" or "scatter" in effects}
    parts = [part for part, names in PARTS.items() if kept & set(names)]
    return {part: made_key(scene, effects, part) for part in parts}


def part_files(parts):
    """Every file of these parts."""
    return [
        f"results/scenes/{part}/{key}/{name}{ending}"
        for part, key in parts.items()
        for name in PARTS[part]
        for ending in STORED[name].endings
    ]


def part_seconds(parts):
    """The files that say what these parts took."""
    return [f"results/scenes/{part}/{key}/seconds.json" for part, key in parts.items()]


def made_before(wildcards, part):
    """What a part goes on from."""
    scene, effects = made_for(wildcards.made)
    needs = {each for name in PARTS[part] for each in upstream(PRODUCTS, name)} - {*PARTS[part]}
    return part_files(scene_parts(scene, effects, needs))


def answered_by(wildcards):
    """The parts that a scene's answer is taken from and made of."""
    scene = wildcards.scene
    return scene_parts(scene, scene_effects(scene, wildcards.model), products_of(SCENES[scene].asked))
