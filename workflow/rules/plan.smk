# What a run would take, before it is begun: a dry run of each target at measured costs.
import time


localrules:
    plan,  # it is for the one who waits at the terminal


rule plan:
    """Before a run: scenes and their effects, jobs, expected minutes and memory of every target."""
    input:
        costs=str(HERE / "config/costs.tsv"),
        measured=home("config/accuracy/measured.csv"),
    output:
        "results/study/plan.csv",
    params:
        dry_run=[
            *(PYTHON, "-m", "snakemake", "--dry-run", "--quiet", "rules"),
            *asked_settings(),
            *("--snakefile", str(HOME / "workflow" / "Snakefile")),
        ],
        targets=[
            *("study", *(name for name in PAGES if name not in allowed.QUESTIONS or able(name))),
            *(f"campaign_{name}" for name in CAMPAIGNS),
        ],
        idle=lambda wildcards: sorted(rule.name for rule in workflow.rules if rule.norun),
        campaigns=lambda wildcards: {f"campaign_{name}": campaign_cost(name) for name in CAMPAIGNS},
        scenes={name: effects_or_file(name) for name in SCENES},
        cores=AT_A_TIME,
        now=time.time(),  # what there is to do changes with every run, which no file says,
        library=library("plan.py"),
    log:
        "results/logs/plan.log",
    benchmark:
        "results/benchmarks/plan/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/plan.py"
