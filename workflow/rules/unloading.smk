# The ways to the stress-free shape, compared where it is known: on the digital volunteers themselves.
UNLOADING = config["mechanics"]["unloading"]


rule score_unloading:
    """All methods on one digital volunteer's own body, with the right moduli, for one modulus of fat and gland."""
    output:
        "results/scores/{w}/unloading_{kpa}kpa.csv",
    params:
        woman=lambda wildcards: config["digital"]["women"][wildcards.w],
        tissues=TISSUES,
        element_mm=UNLOADING["element_mm"],
        library=library("score_unloading.py"),
    log:
        "results/logs/score_unloading/{w}_{kpa}kpa.log",
    benchmark:
        "results/benchmarks/score_unloading/{w}_{kpa}kpa.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/score_unloading.py"
