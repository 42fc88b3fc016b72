# What accuracy costs in time, on demand. One job per value of a knob: adding one runs one.
from mammosim.chain.graph import pruned, read_by
from mammosim.study.accuracy.knobs import knobs
from mammosim.study.accuracy.trial import IMAGES, PRODUCTS

ACCURACY = checked(read_yaml(config["accuracy"]), "accuracy", [config["accuracy"]])
TRIED = ACCURACY["volunteer"]  # the volunteer
TRIED_PRODUCTS = {**IMAGES, **PRODUCTS}
TRIED_WAY = ACCURACY["load"]["strategy"]
TRIED_LOAD = {
    "position": ACCURACY["load"]["position"],
    "thickness_mm": COMPRESSION["thickness_mm"].get(TRIED),
    "strategy": known_strategies([TRIED_WAY], WAYS, config["accuracy"])[TRIED_WAY],
}
TRIED_SETTINGS = chain_settings(TISSUES, TRIED_LOAD) | {
    name: config[name] for name in ("registration", "segmentation")
}
try:
    KNOBS = knobs(ACCURACY["knobs"], TRIED_SETTINGS)
except ConfigurationError as error:
    raise WorkflowError(f"ConfigurationError: {config['accuracy']}: {error}") from None
ASKED = list(dict.fromkeys(name for knob in KNOBS.values() for name in knob.quantities))
PAGES["accuracy"] = {
    "tables": ["accuracy", "accuracy_orders", "accuracy_budget", "accuracy_presets"],
    "figures": [*(f"accuracy_{name}" for name in ASKED), "accuracy_memory", "accuracy_orders", "accuracy_budget"],
}


wildcard_constraints:
    knob="|".join(KNOBS),
    value="[A-Za-z0-9_.+-]+",


rule accuracy_start:
    """The chain of one breast at today's settings, which every trial begins with."""
    input:
        unpack(tried_inputs),
        library=library("accuracy_start.py"),
    output:
        folder=directory("results/accuracy/start"),
        table="results/accuracy/chain.csv",
    params:
        given=tried,
        quantities=ASKED,
    log:
        "results/logs/accuracy_start/all.log",
    benchmark:
        "results/benchmarks/accuracy_start/all.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/accuracy_start.py"


rule accuracy_trial:
    """One value of one knob: what is answered with it, and its processor time and memory."""
    input:
        unpack(tried_inputs),
        start="results/accuracy/start",
        library=library("accuracy_trial.py"),
    output:
        "results/accuracy/{knob}/{value}.csv",
    params:
        given=tried,
        knob=lambda wildcards: KNOBS[wildcards.knob].alone(wildcards.value),
        repeats=ACCURACY["repeats"],
    log:
        "results/logs/accuracy_trial/{knob}_{value}.log",
    benchmark:
        "results/benchmarks/accuracy_trial/{knob}_{value}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/accuracy_trial.py"


rule accuracy_tables:
    """Error, seconds and memory of every trial, orders and exponents, error budget, presets."""
    input:
        rows=[
            "results/accuracy/chain.csv",
            *(f"results/accuracy/{knob.name}/{value.name}.csv" for knob in KNOBS.values() for value in knob.values),
        ],
        library=library("accuracy_tables.py"),
    output:
        table="results/study/accuracy.csv",
        orders="results/study/accuracy_orders.csv",
        budget="results/study/accuracy_budget.csv",
        presets="results/study/accuracy_presets.csv",
        numbers="results/study/accuracy.json",
        files=expand("results/accuracy/presets/{preset}.yaml", preset=ACCURACY["presets"]),
    params:
        limits=ACCURACY["presets"],
    log:
        "results/logs/accuracy_tables/all.log",
    benchmark:
        "results/benchmarks/accuracy_tables/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/accuracy_tables.py"


rule figure_accuracy:
    """Error in one quantity against processor time of every knob, with the Pareto front and today's setting."""
    input:
        table="results/study/accuracy.csv",
        library=library("figure_accuracy.py"),
    output:
        "results/study/figures/accuracy_{quantity}.png",
    wildcard_constraints:
        quantity="|".join(ASKED),
    log:
        "results/logs/figure_accuracy/{quantity}.log",
    benchmark:
        "results/benchmarks/figure_accuracy/{quantity}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_accuracy.py"


rule figure_accuracy_memory:
    """Largest memory of the job of every value of every knob."""
    input:
        table="results/study/accuracy.csv",
        library=library("figure_accuracy_memory.py"),
    output:
        "results/study/figures/accuracy_memory.png",
    log:
        "results/logs/figure_accuracy_memory/all.log",
    benchmark:
        "results/benchmarks/figure_accuracy_memory/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_accuracy_memory.py"


rule figure_accuracy_orders:
    """Observed orders of convergence and exponents of cost, with their standard errors."""
    input:
        table="results/study/accuracy_orders.csv",
        library=library("figure_accuracy_orders.py"),
    output:
        "results/study/figures/accuracy_orders.png",
    log:
        "results/logs/figure_accuracy_orders/all.log",
    benchmark:
        "results/benchmarks/figure_accuracy_orders/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_accuracy_orders.py"


rule figure_accuracy_budget:
    """The error of the whole chain at today's settings, knob by knob, and the best next step."""
    input:
        table="results/study/accuracy_budget.csv",
        library=library("figure_accuracy_budget.py"),
    output:
        "results/study/figures/accuracy_budget.png",
    log:
        "results/logs/figure_accuracy_budget/all.log",
    benchmark:
        "results/benchmarks/figure_accuracy_budget/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_accuracy_budget.py"


rule accuracy:
    """What accuracy costs in time, on demand: results/study/accuracy.csv and accuracy.html."""
    input:
        **page("accuracy"),
        library=library("page.py"),
    output:
        "results/study/accuracy.html",
    log:
        "results/logs/accuracy/all.log",
    benchmark:
        "results/benchmarks/accuracy/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
