# Functions of the scenes: their files, settings and families, and what each of their jobs begins with.
import hashlib
import json


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


def preset(accuracy):
    """The overrides of config/accuracy/{accuracy}.yaml, or the cheapest settings that meet its errors."""
    try:
        if isinstance(accuracy, dict):
            choice = chosen(pd.read_csv(home("config/accuracy/measured.csv"), comment="#"), accuracy)
            return nested(choice.settings)
        return read_yaml(f"config/accuracy/{accuracy}.yaml") or {}
    except FileNotFoundError:
        known = ", ".join(sorted(path.stem for path in (HOME / "config/accuracy").glob("*.yaml")))
        raise WorkflowError(f"ConfigurationError: no preset {accuracy!r}; choose one of: {known}") from None
    except ConfigurationError as error:
        raise WorkflowError(f"ConfigurationError: {error}") from None


def scene_settings(name, accuracy):
    """What the chain of a scene reads, at a preset or at the errors asked for."""
    values = SCENE_VALUES[name]
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
    auto = wildcards.model == "screened" and SCENES[wildcards.scene].effects == "auto"
    return [f"results/scenes/screening/{FAMILY[wildcards.scene]}.csv"] if auto else []


def stored_files(scene, model, products):
    """The files of some products of a scene."""
    folder = f"results/scenes/{scene}/{model}"
    return [f"{folder}/{name}{ending}" for name in products for ending in STORED[name].endings]


def kept_for(wildcards, products):
    """Those of the products that are kept as files, and that this scene's effects leave anything of."""
    effects = scene_effects(wildcards.scene, wildcards.model)
    return [name for name in products if name in STORED and (name != "scatter" or "scatter" in effects)]


def scene_files_before(wildcards, part):
    """What a part of a scene goes on from."""
    needs = dict.fromkeys(each for name in PARTS[part] for each in upstream(PRODUCTS, name))
    before = [name for name in kept_for(wildcards, needs) if name not in PARTS[part]]
    return stored_files(wildcards.scene, wildcards.model, before)


def scene_answer_files(wildcards):
    """Every kept product that the asked quantities are made of."""
    asked = products_of(SCENES[wildcards.scene].asked)
    return stored_files(wildcards.scene, wildcards.model, kept_for(wildcards, asked))


def scene_seconds(wildcards):
    """What each part of the answer took."""
    asked = kept_for(wildcards, products_of(SCENES[wildcards.scene].asked))
    parts = [part for part, products in PARTS.items() if set(products) & set(asked)]
    return [f"results/scenes/{wildcards.scene}/{wildcards.model}/{part}_seconds.json" for part in parts]
