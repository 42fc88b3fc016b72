# What the fit is worth: a position that it never saw, and what its uncertainty means for what follows.
VALIDATION = config["validation"]
PROPAGATION = config["propagation"]
WRONG_MODEL = VALIDATION["wrong_model"]
WITH_REFERENCES = [*WRONG_MODEL, *WRONG_MODEL.values()]
PAGES["wrong_model"] = {"tables": ["wrong_model", "wrong_model_moduli"], "figures": ["wrong_model"]}
PRESSED = ["fit", *range(PROPAGATION["pressed"])]


wildcard_constraints:
    rank="fit|[0-9]+",


rule validate:
    """One measured position against the prediction of the fitted body: markers, nipples, skin."""
    input:
        moduli="results/identification/{v}/moduli.csv",
        fit="results/identification/{v}/fit.csv",
        stress_free="results/identification/{v}/stress_free.vtu",
        start="results/meshes/{v}/prone.vtu",
        start_fiducials="results/registration/{v}/prone_fiducials.csv",
        measured="results/meshes/{v}/{p}.vtu",
        fiducials="results/registration/{v}/{p}_fiducials.csv",
        transform="results/registration/{v}/{p}.tfm",
    output:
        rows="results/validation/{v}/{p}.csv",
        shape="results/validation/{v}/{p}.vtu",
    params:
        fitted=lambda wildcards: wildcards.p in SEGMENTED,
        gravity=lambda wildcards: gravity(wildcards.v, wildcards.p),
        tissues=TISSUES,
        library=library("validate.py"),
    log:
        "results/logs/validate/{v}_{p}.log",
    benchmark:
        "results/benchmarks/validate/{v}_{p}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/validate.py"


rule propagate:
    """Every draw of the fit unloaded from the measured prone shape, and loaded in the held-out position."""
    input:
        samples="results/identification/{v}/samples.csv",
        stress_free="results/identification/{v}/stress_free.vtu",
        mesh="results/meshes/{v}/prone.vtu",
        fiducials="results/registration/{v}/prone_fiducials.csv",
        from_transform="results/registration/{v}/prone.tfm",
        to_transform="results/registration/{v}/{p}.tfm",
    output:
        nipples="results/propagation/{v}/{p}_nipples.csv",
        rests="results/propagation/{v}/{p}_stress_free.vtu",
    params:
        draws=PROPAGATION["draws"],
        gravity=lambda wildcards: [gravity(wildcards.v, "prone"), gravity(wildcards.v, wildcards.p)],
        tissues=TISSUES,
        library=library("propagate.py"),
    log:
        "results/logs/propagate/{v}_{p}.log",
    benchmark:
        "results/benchmarks/propagate/{v}_{p}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/propagate.py"


rule propagate_press:
    """The fit between the plates, or the draw of one rank of stiffness: force and dose."""
    input:
        unpack(lambda wildcards: breast_of(wildcards.v, "mesh", "spectrum")),
        samples="results/identification/{v}/samples.csv",
        rests=lambda wildcards: f"results/propagation/{wildcards.v}/{held_out(wildcards.v)[0]}_stress_free.vtu",
        order=lambda wildcards: order_of(wildcards) if wildcards.rank != "fit" else [],
    output:
        row="results/propagation/{v}/{side}_{rank}.csv",
        shape="results/propagation/{v}/{side}_{rank}.vtu",
    params:
        pressed=PROPAGATION["pressed"],
        given=lambda wildcards: propagated_given(wildcards.v, wildcards.side),
        library=library("propagate_press.py", "exposed_dose"),
    log:
        "results/logs/propagate_press/{v}_{side}_{rank}.log",
    benchmark:
        "results/benchmarks/propagate_press/{v}_{side}_{rank}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/propagate_press.py"


rule propagate_order:
    """How much energy every draw would store in the fit's shape between the plates: its order of stiffness."""
    input:
        samples="results/identification/{v}/samples.csv",
        rests=lambda wildcards: f"results/propagation/{wildcards.v}/{held_out(wildcards.v)[0]}_stress_free.vtu",
        fit="results/propagation/{v}/{side}_fit.vtu",
        mesh="results/meshes/{v}/prone.vtu",
    output:
        "results/propagation/{v}/{side}_order.csv",
    params:
        draws=PROPAGATION["draws"],
        tissues=TISSUES,
        library=library("propagate_order.py"),
    log:
        "results/logs/propagate_order/{v}_{side}.log",
    benchmark:
        "results/benchmarks/propagate_order/{v}_{side}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/propagate_order.py"


rule propagation_rows:
    """The interval of everything that follows from the moduli, beside what was measured."""
    input:
        nipples=lambda wildcards: f"results/propagation/{wildcards.v}/{held_out(wildcards.v)[0]}_nipples.csv",
        fiducials=lambda wildcards: f"results/registration/{wildcards.v}/{held_out(wildcards.v)[0]}_fiducials.csv",
        order=expand("results/propagation/{{v}}/{side}_order.csv", side=COMPRESSION["sides"]),
        pressed=expand("results/propagation/{{v}}/{side}_{rank}.csv", side=COMPRESSION["sides"], rank=PRESSED),
    output:
        rows="results/propagation/{v}/rows.csv",
        pressed_rows="results/propagation/{v}/pressed.csv",
    params:
        library=library("propagation_rows.py"),
    log:
        "results/logs/propagation_rows/{v}.log",
    benchmark:
        "results/benchmarks/propagation_rows/{v}.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/propagation_rows.py"


rule wrong_model_table:
    """What a fit whose model leaves something out costs: errors and moduli beside those of a reference volunteer."""
    input:
        validated=lambda wildcards: [f"results/validation/{v}/{p}.csv" for v in WITH_REFERENCES for p in validated(v)],
        moduli=expand("results/identification/{v}/moduli.csv", v=WITH_REFERENCES),
    output:
        table="results/study/wrong_model.csv",
        moduli="results/study/wrong_model_moduli.csv",
        numbers="results/study/wrong_model.json",
    params:
        references=WRONG_MODEL,
        library=library("wrong_model_table.py"),
    log:
        "results/logs/wrong_model_table/all.log",
    benchmark:
        "results/benchmarks/wrong_model_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/wrong_model_table.py"


rule wrong_model:
    """What a fit costs whose model leaves out what the woman has, on demand: results/study/wrong_model.html."""
    input:
        **page("wrong_model"),
    output:
        "results/study/wrong_model.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/wrong_model/all.log",
    benchmark:
        "results/benchmarks/wrong_model/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
