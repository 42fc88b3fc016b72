# Scenes: a question each, the effects that it calls for, and only the jobs that its answer needs.
from mammosim.study.scenes.scene import Scene, products_of

SCREENING = config["scenes"]
SCENES = {name: known_scene(name) for name in SCREENING["names"]}
# Scenes of one breast, tissues and load share all that they have in common while they are screened.
FAMILY = {name: family_of(scene) for name, scene in SCENES.items()}
PAGES["scenes"] = {"tables": ["scenes", "effects", "interactions"], "figures": ["effects", "scenes"]}


wildcard_constraints:
    scene="|".join(SCENES),
    model="screened|full",


checkpoint screen:
    """Which effects each scene of a family calls for: what leaving them out or adding them does, on the coarse model."""
    input:
        unpack(lambda wildcards: breast_of(volunteer_of_family(wildcards.family))),
    output:
        effects="results/scenes/screening/{family}.csv",
        joint="results/scenes/screening/{family}_joint.csv",
        seconds="results/scenes/screening/{family}.json",
    params:
        scenes=lambda wildcards: {s: to_screen(s) for s in scenes_of_family(wildcards.family)},
        given=screening_given,
        rule={key: SCREENING[key] for key in ("part", "joint_part", "pairs")},
        library=library("screen.py", *STAGES),
    wildcard_constraints:
        family="|".join({*FAMILY.values()}),
    log:
        "results/logs/screen/{family}.log",
    benchmark:
        "results/benchmarks/screen/{family}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/screen.py"


rule scene_answer:
    """What one scene asks, with the screened effects or with all, and what all of it took."""
    input:
        unpack(lambda wildcards: breast_of(SCENES[wildcards.scene].volunteer)),
        unpack(answer_inputs),
        screening=screening_of,
    output:
        "results/scenes/answers/{scene}_{model}.json",
    params:
        scene=lambda wildcards: question(wildcards.scene),
        given=lambda wildcards: job_given(
            products_of(SCENES[wildcards.scene].asked),
            scene_places(wildcards.scene),
            scene_settings(wildcards.scene),
            sorted(scene_effects(wildcards.scene, wildcards.model)),
        ),
        library=library("scene_answer.py", *STAGES),
    log:
        "results/logs/scene_answer/{scene}_{model}.log",
    benchmark:
        "results/benchmarks/scene_answer/{scene}_{model}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/scene_answer.py"


rule scenes_table:
    """Every scene's answer with the screened effects beside that of the full model, and every decision."""
    input:
        answers=expand("results/scenes/answers/{scene}_{model}.json", scene=SCENES, model=["screened", "full"]),
        effects=expand("results/scenes/screening/{family}.csv", family=families_to_screen()),
        joint=expand("results/scenes/screening/{family}_joint.csv", family=families_to_screen()),
        seconds=expand("results/scenes/screening/{family}.json", family=families_to_screen()),
        measured=home("config/accuracy/measured.csv"),
    output:
        scenes="results/study/scenes.csv",
        effects="results/study/effects.csv",
        interactions="results/study/interactions.csv",
        numbers="results/study/scenes.json",
        variants="results/variants.tsv",
    params:
        scenes=lambda wildcards: {name: question(name) for name in SCENES},
        settings=lambda wildcards: {
            name: pruned(scene_settings(name), read_by(STAGES, products_of(SCENES[name].asked))) for name in SCENES
        },
        variants=lambda wildcards: all_variants(),
        accuracy=lambda wildcards: {name: accuracy_words(name) for name in SCENES},
        library=library("scenes_table.py"),
    log:
        "results/logs/scenes_table/all.log",
    benchmark:
        "results/benchmarks/scenes_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/scenes_table.py"


rule scenes:
    """Scenes with only the effects that they call for, on demand: results/study/scenes.csv and scenes.html."""
    input:
        **page("scenes"),
    output:
        "results/study/scenes.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/scenes/all.log",
    benchmark:
        "results/benchmarks/scenes/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
