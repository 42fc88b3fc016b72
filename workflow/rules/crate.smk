# The results as a research object that others can read without this program.


rule crate:
    """On demand: tables, figures and report with what made them, as an RO-Crate: results/crate."""
    input:
        results=[
            "results/study/report.html",
            *PAGE_SCRIPTS,
            *VIEW,
            *expand("results/study/{name}.json", name=["numbers", "provenance"]),
            *expand("results/study/{name}.csv", name=["missing", "not_planned"]),
            *expand("results/study/{name}.csv", name=[*(name for name, rows in TABLES.items() if rows), *MADE_BESIDE]),
            *expand("results/study/figures/{name}.{kind}", name=[*PICTURES, "cost"], kind=["png", "pdf"]),
        ],
    output:
        directory("results/crate"),
    params:
        home=str(HERE),
        library=library("crate.py"),
    log:
        "results/logs/crate.log",
    benchmark:
        "results/benchmarks/crate/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/crate.py"
