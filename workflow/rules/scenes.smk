# Scenes: a question each, the effects that it calls for, and only the jobs that its answer needs.
from functools import partial

from mammosim.chain.graph import upstream
from mammosim.chain.files import STORED
from mammosim.chain.stages import PRODUCTS, effects_on
from mammosim.study.scenes.scene import Scene, products_of

SCREENING = config["scenes"]
SCENE_VALUES = {name: scene_values(name) for name in SCREENING["names"]}
SCENES = {name: known_scene(name, values) for name, values in SCENE_VALUES.items()}
# Scenes of one breast, tissues and load share all that they have in common while they are screened.
FAMILY = {name: family_of(values) for name, values in SCENE_VALUES.items()}
GROUP = {name: group_of(name) for name in SCENES}
# What one job makes and keeps.
PARTS = {"body": ["mesh", "stress_free"], **{name: [name] for name in STORED if name not in ("mesh", "stress_free")}}
PAGES["scenes"] = {"tables": ["scenes", "effects", "interactions"], "figures": ["effects", "scenes"]}


wildcard_constraints:
    scene="|".join(SCENES),
    model="screened|full",
    made="[a-z0-9_.]+",


checkpoint screen:
    """Which effects each scene of a family calls for: what leaving them out or adding them does, on the coarse model."""
    input:
        unpack(lambda wildcards: breast_inputs(volunteer_of_family(wildcards.family))),
        library=library("screen.py"),
    output:
        effects="results/scenes/screening/{family}.csv",
        joint="results/scenes/screening/{family}_joint.csv",
        seconds="results/scenes/screening/{family}.json",
    params:
        scenes=lambda wildcards: {s: to_screen(s) for s in scenes_of_family(wildcards.family)},
        settings=lambda wildcards: screening_settings(wildcards.family),
        gravity=lambda wildcards: gravity(volunteer_of_family(wildcards.family), STRESS_FREE["position"]),
        rule={key: SCREENING[key] for key in ("part", "joint_part", "pairs")},
        seed=config["seed"],
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


for part, products in PARTS.items():

    rule:
        name:
            f"scene_{part}"
        input:
            unpack(lambda wildcards: breast_inputs(SCENE_VALUES[made_for(wildcards.made)[0]]["volunteer"])),
            made=partial(made_before, part=part),
            library=library("scene_part.py"),
        output:
            seconds=f"results/scenes/{part}/{{made}}/seconds.json",
            files=part_files({part: "{made}"}),
        params:
            scene=lambda wildcards: whose(made_for(wildcards.made)[0]),
            effects=lambda wildcards: made_for(wildcards.made)[1],
            settings=partial(made_settings, part=part),
            gravity=lambda wildcards: gravity(
                SCENE_VALUES[made_for(wildcards.made)[0]]["volunteer"], STRESS_FREE["position"]
            ),
            products=products,
            seed=config["seed"],
        log:
            f"results/logs/scene_{part}/{{made}}.log",
        benchmark:
            f"results/benchmarks/scene_{part}/{{made}}.tsv"
        resources:
            mem_mb=4000,
        script:
            "../scripts/scene_part.py"


rule scene_answer:
    """What one scene asks, with the screened effects or with all, and what all parts of it took."""
    input:
        unpack(lambda wildcards: breast_inputs(SCENE_VALUES[wildcards.scene]["volunteer"])),
        made=lambda wildcards: part_files(answered_by(wildcards)),
        seconds=lambda wildcards: part_seconds(answered_by(wildcards)),
        screening=screening_of,
        library=library("scene_answer.py"),
    output:
        "results/scenes/answers/{scene}_{model}.json",
    params:
        scene=lambda wildcards: question(wildcards.scene),
        settings=lambda wildcards: scene_settings(wildcards.scene, products_of(SCENES[wildcards.scene].asked)),
        gravity=lambda wildcards: gravity(SCENE_VALUES[wildcards.scene]["volunteer"], STRESS_FREE["position"]),
        seed=config["seed"],
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
        library=library("scenes_table.py"),
    output:
        scenes="results/study/scenes.csv",
        effects="results/study/effects.csv",
        interactions="results/study/interactions.csv",
        numbers="results/study/scenes.json",
    params:
        scenes=lambda wildcards: {name: question(name) for name in SCENES},
        settings=lambda wildcards: {name: scene_settings(name, products_of(SCENES[name].asked)) for name in SCENES},
        accuracy=lambda wildcards: {name: accuracy_words(name) for name in SCENES},
    log:
        "results/logs/scenes_table/all.log",
    benchmark:
        "results/benchmarks/scenes_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/scenes_table.py"


rule figure_effects:
    """What every effect does to every answer, in parts of its tolerance, and which were kept."""
    input:
        table="results/study/effects.csv",
        library=library("figure_effects.py"),
    output:
        "results/study/figures/effects.png",
    log:
        "results/logs/figure_effects/all.log",
    benchmark:
        "results/benchmarks/figure_effects/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_effects.py"


rule figure_scenes:
    """The answers of the screened model beside those of the full one, and their time."""
    input:
        table="results/study/scenes.csv",
        library=library("figure_scenes.py"),
    output:
        "results/study/figures/scenes.png",
    log:
        "results/logs/figure_scenes/all.log",
    benchmark:
        "results/benchmarks/figure_scenes/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_scenes.py"


rule scenes:
    """Scenes with only the effects that they call for, on demand: results/study/scenes.csv and scenes.html."""
    input:
        **page("scenes"),
        library=library("page.py"),
    output:
        "results/study/scenes.html",
    log:
        "results/logs/scenes/all.log",
    benchmark:
        "results/benchmarks/scenes/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
