# Are true moduli found? Of virtual patients, one per seed, on demand; and of the study's digital volunteers.
PAGES["recovery"] = {"tables": ["recovery", "recovery_tissues", "recovery_draws"], "figures": ["recovery"]}


rule score_moduli:
    """The fitted moduli of a digital volunteer beside the true ones."""
    input:
        fitted="results/identification/{w}/moduli.csv",
        fit="results/identification/{w}/fit.csv",
        truth="results/truth/{w}/moduli.csv",
    output:
        "results/scores/{w}/moduli.csv",
    params:
        seed=lambda wildcards: MADE.get(wildcards.w, config["seed"]),
        library=library("score_moduli.py"),
    log:
        "results/logs/score_moduli/{w}.log",
    benchmark:
        "results/benchmarks/score_moduli/{w}.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/score_moduli.py"


rule score_draws:
    """Every sample of the virtual patients, and how it ended."""
    input:
        rows=expand("results/truth/{w}/draws.csv", w=MADE),
    output:
        "results/study/recovery_draws.csv",
    params:
        library=library("table.py"),
    log:
        "results/logs/score_draws/all.log",
    benchmark:
        "results/benchmarks/score_draws/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/table.py"


rule recovery_table:
    """The moduli of all virtual patients, and how often the truth lies in its interval."""
    input:
        rows=expand("results/scores/{w}/moduli.csv", w=MADE),
    output:
        table="results/study/recovery.csv",
        tissues="results/study/recovery_tissues.csv",
        numbers="results/study/recovery.json",
    params:
        library=library("recovery_table.py"),
    log:
        "results/logs/recovery_table/all.log",
    benchmark:
        "results/benchmarks/recovery_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/recovery_table.py"


rule recovery:
    """Moduli of virtual patients found again, on demand: results/study/recovery.csv and recovery.html."""
    input:
        **page("recovery"),
    output:
        "results/study/recovery.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/recovery/all.log",
    benchmark:
        "results/benchmarks/recovery/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
