# Functions of the scenes: their files, settings and families, and what each of their jobs begins with.
import hashlib
import json

from mammosim.io.tables import read_commented
from mammosim.study.presets import chosen

MADE_FOR = {}  # the name of a part that is kept -> a scene, and the effects, that it belongs to


def scene_values(name):
    """The values of config/scenes/{name}.yaml, with the volunteer and side that it leaves to the study."""
    file = f"config/scenes/{name}.yaml"
    values = checked(read_yaml(file), "scene", [file])
    values = {"volunteer": WOMEN[0], "side": COMPRESSION["sides"][0]} | values
    strategy = values["load"].get("strategy")
    if strategy is not None:
        known_strategies([strategy], WAYS)
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


def volunteer_of_family(family):
    """Whose breast it is."""
    return next(values["volunteer"] for name, values in SCENE_VALUES.items() if FAMILY[name] == family)


def overridden(values, others):
    """Nested values with others in their place."""
    merged = {**values}
    for key, value in others.items():
        nested = isinstance(value, dict) and isinstance(values.get(key), dict)
        merged[key] = overridden(values[key], value) if nested else value
    return merged


def nested(settings):
    """Settings with dotted names as nested values."""
    values = {}
    for name, value in settings.items():
        for part in reversed(name.split(".")):
            value = {part: value}
        values = overridden(values, value)
    return values


@cache
def picked(accuracy):
    """The cheapest settings that meet errors (JSON, quantity -> error) by the measured curves; says which."""
    choice = chosen(read_commented(home("config/accuracy/measured.csv")), json.loads(accuracy))
    if workflow.is_main_process:
        settings = ", ".join(f"{name} {value}" for name, value in choice.settings.items())
        errors = ", ".join(f"{name} {error:.2g}" for name, error in choice.errors.items())
        logger.info(f"accuracy {accuracy} is met by {settings}: {errors}, {choice.seconds:.0f} s")
    return choice


def preset(accuracy):
    """The overrides of config/accuracy/{accuracy}.yaml, or the cheapest settings that meet its errors."""
    try:
        if isinstance(accuracy, dict):
            return nested(picked(json.dumps(accuracy)).settings)
        return read_yaml(f"config/accuracy/{accuracy}.yaml") or {}
    except FileNotFoundError:
        known = ", ".join(sorted(path.stem for path in (HOME / "config/accuracy").glob("*.yaml")))
        raise WorkflowError(f"ConfigurationError: no preset {accuracy!r}; choose one of: {known}") from None
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None


def scene_settings(name, accuracy=None):
    """What the chain of a scene reads, at its own accuracy or another one: a preset, or errors asked for."""
    values, accuracy = SCENE_VALUES[name], accuracy or SCENES[name].accuracy
    load = {**values["load"], "thickness_mm": COMPRESSION["thickness_mm"][values["volunteer"]]}
    if "strategy" in load:
        load["strategy"] = WAYS[load["strategy"]]
    settings = chain_settings(tissue_table(values["tissues"]), load)
    return overridden(settings, {k: v for k, v in preset(accuracy).items() if k in settings})


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
    """Under which name a part is kept: all scenes in which it is the same share it."""
    values, products = SCENE_VALUES[scene], PARTS[part]
    acting = sorted(set(effects) & effects_on(each for name in products for each in (*upstream(PRODUCTS, name), name)))
    same = {"family": FAMILY[scene], "accuracy": SCENES[scene].accuracy, "effects": acting}
    digest = hashlib.sha256(json.dumps(same, sort_keys=True).encode()).hexdigest()[:12]
    key = f"{values['volunteer']}_{digest}"
    MADE_FOR[key] = (scene, acting)
    return key


def made_for(key):
    """A scene, and the effects, that a part of this name belongs to."""
    if key not in MADE_FOR:  # a job of its own process, which asks for nothing but this part
        for scene, model in ((scene, model) for scene in SCENES for model in ("screened", "full")):
            scene_parts(scene, scene_effects(scene, model), products_of(SCENES[scene].asked))
    return MADE_FOR[key]


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
