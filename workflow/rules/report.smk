# Figures and the report.
rule report:
    """The report."""
    input:
        "results/study/numbers.json",
    output:
        "results/study/report.html",
    log:
        "results/logs/report.log",
    shell:
        "false"
