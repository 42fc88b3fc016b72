# Hard cases of the mechanics, on demand. One job each, so that one that fails leaves the others alone.
HARD_CASES = checked(read_yaml(config["hard_cases"]), "hard_cases", [config["hard_cases"]], finite=False)["cases"]
PAGES["hard_cases"] = {"tables": ["hard_cases"], "figures": ["hard_cases"]}


rule hard_case:
    """What happens in one hard case, against what is expected."""
    output:
        "results/hard_cases/{case}.csv",
    params:
        values=lambda wildcards: HARD_CASES[wildcards.case],
        library=library("hard_case.py"),
    wildcard_constraints:
        case="[a-z0-9_.]+",
    log:
        "results/logs/hard_case/{case}.log",
    benchmark:
        "results/benchmarks/hard_case/{case}.tsv"
    resources:
        mem_mb=1500,
    script:
        "../scripts/hard_case.py"


rule hard_cases_table:
    """Every hard case, and a loud word on each unexpected outcome."""
    input:
        rows=expand("results/hard_cases/{case}.csv", case=HARD_CASES),
    output:
        table="results/study/hard_cases.csv",
        numbers="results/study/hard_cases.json",
    params:
        library=library("hard_cases_table.py"),
    log:
        "results/logs/hard_cases_table/all.log",
    benchmark:
        "results/benchmarks/hard_cases_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/hard_cases_table.py"


rule hard_cases:
    """Hard cases of the mechanics, on demand: results/study/hard_cases.csv and hard_cases.html."""
    input:
        **page("hard_cases"),
    output:
        "results/study/hard_cases.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/hard_cases/all.log",
    benchmark:
        "results/benchmarks/hard_cases/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
