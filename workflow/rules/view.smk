# Bodies that a page turns and cuts.
VIEW = ["results/study/view.html", *over("results/study/view/{v}.js")]


rule view:
    """The bodies of one woman, compact: measured, unloaded, predicted, pressed, with strain, stress and pressure."""
    input:
        bodies=lambda wildcards: [file for each in viewed(wildcards.v) for file in files_viewed(each)],
    output:
        "results/study/view/{v}.js",
    params:
        told=lambda wildcards: viewed(wildcards.v),
        absent=lambda wildcards: absent_words(wildcards.v),
        library=library("view.py"),
    log:
        "results/logs/view/{v}.log",
    benchmark:
        "results/benchmarks/view/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/view.py"


rule view_page:
    """The page on which every body can be turned, coloured by a field, and cut: results/study/view.html."""
    input:
        bodies=over("results/study/view/{v}.js"),
        scripts=PAGE_SCRIPTS,
        provenance="results/study/provenance.json",
    output:
        "results/study/view.html",
    params:
        volunteers=WOMEN,
        library=library("view_page.py"),
    log:
        "results/logs/view_page.log",
    benchmark:
        "results/benchmarks/view_page/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/view_page.py"
