# What accuracy costs in time, on demand. One job per value of a numerical parameter: adding one runs one.
from dataclasses import asdict

from mammosim.study.accuracy.parameters import AccuracySettings, parameters

ACCURACY_VALUES = checked(read_yaml(config["accuracy"]), "accuracy", [config["accuracy"]], known=KNOWN)
TRIED_MEASURED = ("scan", "strokes", "given_labels", "fiducials", "reference_scan", "reference_fiducials", *BOTH)
TRIED_PRODUCTS = ("loaded", "exposed_dose", "mammogram", "slices")
try:
    ACCURACY = AccuracySettings.of(ACCURACY_VALUES)
    TRIED = ACCURACY.volunteer
    TRIED_PLACES = {"v": TRIED, "side": ACCURACY.side, "moduli": "gravity"} | asdict(ACCURACY.load)
    known_strategies([ACCURACY.load.strategy], WAYS, config["accuracy"])
    TRIED_SETTINGS = settings_of(TRIED_PLACES)
    PARAMETERS = parameters(ACCURACY.parameters, TRIED_SETTINGS)
except ConfigurationError as error:
    raise WorkflowError(f"ConfigurationError: {config['accuracy']}: {error}") from None
ASKED = list(dict.fromkeys(name for parameter in PARAMETERS.values() for name in parameter.quantities))
PAGES["accuracy"] = {
    "tables": ["accuracy", "accuracy_orders", "accuracy_budget", "accuracy_presets"],
    "figures": [*(f"accuracy_{name}" for name in ASKED), "accuracy_memory", "accuracy_orders", "accuracy_budget"],
}


wildcard_constraints:
    parameter="|".join(PARAMETERS),
    value="[A-Za-z0-9_.+-]+",


rule accuracy_start:
    """The chain of one breast at today's settings, which every trial begins with."""
    input:
        unpack(lambda wildcards: measured(TRIED, *TRIED_MEASURED)),
    output:
        folder=directory("results/accuracy/start"),
        table="results/accuracy/chain.csv",
    params:
        given=lambda wildcards: job_given(TRIED_PRODUCTS, TRIED_PLACES, TRIED_SETTINGS, EFFECTS),
        quantities=ASKED,
        library=library("accuracy_start.py", *STAGES),
    log:
        "results/logs/accuracy_start/all.log",
    benchmark:
        "results/benchmarks/accuracy_start/all.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/accuracy_start.py"


rule accuracy_trial:
    """One value of one numerical parameter: what is answered with it, and its processor time and memory."""
    input:
        unpack(lambda wildcards: measured(TRIED, *TRIED_MEASURED)),
        start="results/accuracy/start",
    output:
        "results/accuracy/{parameter}/{value}.csv",
    params:
        given=lambda wildcards: job_given(TRIED_PRODUCTS, TRIED_PLACES, TRIED_SETTINGS, EFFECTS),
        parameter=lambda wildcards: PARAMETERS[wildcards.parameter].alone(wildcards.value),
        repeats=asdict(ACCURACY.repeats),
        library=library("accuracy_trial.py", *STAGES),
    log:
        "results/logs/accuracy_trial/{parameter}_{value}.log",
    benchmark:
        "results/benchmarks/accuracy_trial/{parameter}_{value}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/accuracy_trial.py"


rule accuracy_tables:
    """Error, seconds and memory of every trial, orders and exponents, error budget, presets."""
    input:
        rows=[
            "results/accuracy/chain.csv",
            *(f"results/accuracy/{name}/{value.name}.csv" for name, each in PARAMETERS.items() for value in each.values),
        ],
    output:
        table="results/study/accuracy.csv",
        orders="results/study/accuracy_orders.csv",
        budget="results/study/accuracy_budget.csv",
        presets="results/study/accuracy_presets.csv",
        numbers="results/study/accuracy.json",
        files=expand("results/accuracy/presets/{preset}.yaml", preset=ACCURACY.presets),
    params:
        limits=ACCURACY.presets,
        library=library("accuracy_tables.py"),
    log:
        "results/logs/accuracy_tables/all.log",
    benchmark:
        "results/benchmarks/accuracy_tables/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/accuracy_tables.py"


rule accuracy:
    """What accuracy costs in time, on demand: results/study/accuracy.csv and accuracy.html."""
    input:
        **page("accuracy"),
    output:
        "results/study/accuracy.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/accuracy/all.log",
    benchmark:
        "results/benchmarks/accuracy/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
