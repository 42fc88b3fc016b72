# Figures of one or two tables: which function of mammosim.figures draws which tables.
DRAWN = {
    "sweep": ("deformation.sweep", ["sweep"]),
    "convergence": ("deformation.convergence", ["stress_free"]),
    "unloading": ("deformation.unloading", ["unloading"]),
    "amounts": ("strategies.amounts", ["compression_amounts"]),
    "trade_off": ("dose.trade_off", ["trade_off"]),
    "propagation": ("identification.propagation", ["propagation"]),
    "spectra": ("dose.spectra", ["spectra", "beams"]),
    "dose_routes": ("dose.dose_routes", ["dose_routes", "dose_standard"]),
    "report195": ("dose.report195", ["report195"]),
    "hard_cases": ("hard_cases.hard_cases", ["hard_cases"]),
    "softening": ("identification.softening", ["softening"]),
    "effects": ("scenes.effects", ["effects"]),
    "scenes": ("scenes.scenes", ["scenes"]),
    "recovery": ("identification.recovery", ["recovery"]),
    "wrong_model": ("validation.wrong_model", ["wrong_model"]),
    "peers": ("peers.processor_time", ["peers"]),
    "peers_xray": ("peers_xray.tasks", ["peers_xray", "peers_xray_targets"]),
    "accuracy_memory": ("accuracy.memory", ["accuracy"]),
    "accuracy_orders": ("accuracy.orders", ["accuracy_orders"]),
    "accuracy_budget": ("accuracy.budget", ["accuracy_budget"]),
    **{f"accuracy_{quantity}": ("accuracy.accuracy", ["accuracy"]) for quantity in ASKED},
}
# What a function is told besides.
TOLD = {
    "convergence": {"tolerance_mm": STRESS_FREE["tolerance_mm"]},
    **{f"accuracy_{quantity}": {"quantity": quantity} for quantity in ASKED},
}


rule figure:
    """One figure of one or two tables; its function says what it shows."""
    input:
        tables=lambda wildcards: [f"results/study/{name}.csv" for name in DRAWN[wildcards.figure][1]],
        library=drawn_by,
    output:
        "results/study/figures/{figure}.png",
    params:
        function=lambda wildcards: DRAWN[wildcards.figure][0],
        told=lambda wildcards: TOLD.get(wildcards.figure, {}),
    wildcard_constraints:
        figure="|".join(DRAWN),
    log:
        "results/logs/figure/{figure}.log",
    benchmark:
        "results/benchmarks/figure/{figure}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure.py"
