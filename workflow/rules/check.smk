# Two pages of each woman: what was understood of her data before a run, and what was done with them after it.


rule check_page:
    """What was understood of one volunteer's data: pictures, what is planned, and every reason to stop."""
    input:
        lambda wildcards: measured_paths(wildcards.v),
    output:
        page="results/checked/{v}.html",
        verdict="results/checked/{v}.json",
    params:
        rows=lambda wildcards: given_rows(wildcards.v),
        told=lambda wildcards: told_of(wildcards.v)
        | {
            "asked": {
                "found": config["registration"]["chest_markers"] == "found",
                "registered": not data_of(wildcards.v).apart,
                "sides": config["compression"]["sides"],
            },
            "element_mm": config["mesh"]["element_mm"],
            "waits": not all(each["there"] for each in given_rows(wildcards.v)),
            "modelled": modelled_in(wildcards.v),
            "stated": wildcards.v in COMPRESSION["thickness_mm"],
            "compression": {key: COMPRESSION[key] for key in ("sides", "depth_share", "smallest_mm")},
        },
        now=time.time(),  # a look is taken anew each time
        library=library("check_page.py"),
    log:
        "results/logs/check_page/{v}.log",
    benchmark:
        "results/benchmarks/check_page/{v}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/check_page.py"


rule check:
    """Before a run: a page of each volunteer, and whether her data can be used; nothing is computed of them."""
    input:
        verdicts=over("results/checked/{v}.json"),
        pages=over("results/checked/{v}.html"),
    output:
        "results/checked/verdicts.csv",
    params:
        now=time.time(),
        library=library("check.py"),
    log:
        "results/logs/check.log",
    benchmark:
        "results/benchmarks/check/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/check.py"


rule what:
    """What was done with one woman's data, what could not be and why, and what one more series would add."""
    input:
        checked=lambda wildcards: [f"results/checked/{wildcards.v}_{p}.csv" for p in positions(wildcards.v)],
        tables=lambda wildcards: sum(tables_of(wildcards.v).values(), []),
        pictures=lambda wildcards: pictures_of(wildcards.v),
    output:
        "results/women/{v}/what.html",
    params:
        rows=lambda wildcards: given_rows(wildcards.v),
        told=lambda wildcards: told_of(wildcards.v) | {"tables": tables_of(wildcards.v), "modelled": modelled_in(wildcards.v)},
        library=library("what.py"),
    log:
        "results/logs/what/{v}.log",
    benchmark:
        "results/benchmarks/what/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/what.py"
