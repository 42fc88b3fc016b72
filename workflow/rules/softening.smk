# Moduli that rise and fall within a month, on demand: the fitted breast, its moduli changed, loaded and pressed again.
SOFTENING = config["softening"]
PAGES["softening"] = {"tables": ["softening"], "figures": ["softening"]}


rule soften:
    """One breast with its fitted moduli, and with other ones: nipple, force, thickness and dose."""
    input:
        unpack(lambda wildcards: breast_of(wildcards.v)),
        moduli="results/identification/{v}/moduli.csv",
        fit="results/identification/{v}/fit.csv",
    output:
        "results/softening/{v}/{side}.csv",
    params:
        given=lambda wildcards: softening_given(wildcards.v, wildcards.side),
        factors=SOFTENING["factors"],
        library=library("soften.py", "loaded", "exposed_dose"),
    log:
        "results/logs/soften/{v}_{side}.log",
    benchmark:
        "results/benchmarks/soften/{v}_{side}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/soften.py"


rule softening_table:
    """All breasts with other moduli, and the largest changes."""
    input:
        rows=lambda wildcards: over("results/softening/{v}/{side}.csv", some_able("softening"), side=COMPRESSION["sides"]),
    output:
        table="results/study/softening.csv",
        numbers="results/study/softening.json",
    params:
        library=library("softening_table.py"),
    log:
        "results/logs/softening_table/all.log",
    benchmark:
        "results/benchmarks/softening_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/softening_table.py"


rule softening:
    """Moduli softer and stiffer within a month, on demand: results/study/softening.csv and softening.html."""
    input:
        **page("softening"),
    output:
        "results/study/softening.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/softening/all.log",
    benchmark:
        "results/benchmarks/softening/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
