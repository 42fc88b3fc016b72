# Published models of the breast, on demand: all on the same woman, and what each does otherwise than the study.
PUBLISHED = config["models"]["names"]
MODELS = known_models(PUBLISHED)
PAGES["models"] = {"tables": ["models"], "figures": ["models"]}


wildcard_constraints:
    published="|".join(MODELS),


rule published_model:
    """One published model on one breast: nipples, stress-free shape, force; what fails is said in its row."""
    input:
        unpack(model_inputs),
    output:
        row="results/models/{v}/{side}/{published}.csv",
        shape="results/models/{v}/{side}/{published}.vtu",
    params:
        model=lambda wildcards: MODELS[wildcards.published].plain,
        given=model_given,
        library=library("published_model.py", "mesh", "mean_shape", "unloaded", "press_setup", "standard_path"),
    log:
        "results/logs/published_model/{v}_{side}_{published}.log",
    benchmark:
        "results/benchmarks/published_model/{v}_{side}_{published}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/published_model.py"


rule score_model:
    """A published model's stress-free shape and upright nipple beside the truth of a digital volunteer."""
    input:
        row="results/models/{w}/{side}/{published}.csv",
        shape="results/models/{w}/{side}/{published}.vtu",
        truth="results/truth/{w}/stress_free.vtu",
        motion=lambda wildcards: f"results/truth/{wildcards.w}/{reference_of(wildcards.w)}_motion.tfm",
        upright_points="results/truth/{w}/upright_points.csv",
        upright_motion="results/truth/{w}/upright_motion.tfm",
    output:
        "results/scores/{w}/{side}/model_{published}.csv",
    params:
        library=library("score_model.py"),
    log:
        "results/logs/score_model/{w}_{side}_{published}.log",
    benchmark:
        "results/benchmarks/score_model/{w}_{side}_{published}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/score_model.py"


rule models_table:
    """Every published model with its row and score, and the numbers that the page quotes."""
    input:
        rows=expand("results/models/{v}/{side}/{published}.csv", v=WOMEN[:1], side=COMPRESSION["sides"][:1], published=MODELS),
        scores=expand(
            "results/scores/{w}/{side}/model_{published}.csv",
            w=[w for w in WOMEN[:1] if w in DIGITAL_WOMEN],
            side=COMPRESSION["sides"][:1],
            published=MODELS,
        ),
    output:
        table="results/study/models.csv",
        numbers="results/study/models.json",
    params:
        library=library("models_table.py"),
    log:
        "results/logs/models_table/all.log",
    benchmark:
        "results/benchmarks/models_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/models_table.py"


rule models:
    """Published models on the same woman, on demand: results/study/models.csv and models.html."""
    input:
        **page("models"),
    output:
        "results/study/models.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/models/all.log",
    benchmark:
        "results/benchmarks/models/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
