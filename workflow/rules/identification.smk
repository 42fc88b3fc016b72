# Moduli from the prone and the supine position. Nothing here may read the truth or a held-out position.
IDENTIFICATION = config["identification"]
FITTED_TO = ("prone", REFERENCE)  # the body is the mesh of the first, and is loaded in the second


rule identify:
    """Moduli by side and tissue from two positions, with their intervals, draws and the stress-free shape."""
    input:
        unpack(pair_inputs),
    output:
        moduli="results/identification/{v}/moduli.csv",
        samples="results/identification/{v}/samples.csv",
        stress_free="results/identification/{v}/stress_free.vtu",
        fit="results/identification/{v}/fit.csv",
        history="results/identification/{v}/history.csv",
    params:
        gravity=pair_gravity,
        tissues=TISSUES,
        settings={key: value for key, value in IDENTIFICATION.items() if key != "grid"},
        seed=config["seed"],
        library=library("identify.py"),
    log:
        "results/logs/identify/{v}.log",
    benchmark:
        "results/benchmarks/identify/{v}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/identify.py"


rule identify_grid:
    """Grid search: what is left of skin and markers for every pair of moduli."""
    input:
        unpack(pair_inputs),
    output:
        "results/identification/{v}/grid.csv",
    params:
        gravity=pair_gravity,
        tissues=TISSUES,
        settings={key: IDENTIFICATION[key] for key in ("prior", "grid")},
        library=library("identify_grid.py"),
    log:
        "results/logs/identify_grid/{v}.log",
    benchmark:
        "results/benchmarks/identify_grid/{v}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/identify_grid.py"


rule moduli_ratio:
    """How much stiffer tissues are under compression than under gravity, in the literature and fitted here."""
    input:
        fitted="results/study/identification.csv",
    output:
        "results/identification/ratio.csv",
    params:
        library=library("moduli_ratio.py"),
    log:
        "results/logs/moduli_ratio/all.log",
    benchmark:
        "results/benchmarks/moduli_ratio/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/moduli_ratio.py"
