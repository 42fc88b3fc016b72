# One position's mesh in the shape of another: what the stress-free methods start from.
MORPH = config["morph"]


rule morph:
    """Prone morphed onto the shape of supine, and the mean of the two, by the surfaces alone."""
    input:
        prone="results/meshes/{v}/prone.vtu",
        supine="results/meshes/{v}/supine.vtu",
        library=library("morph.py"),
    output:
        morphed="results/morph/{v}/supine.vtu",
        mean="results/morph/{v}/mean_start.vtu",
        history="results/morph/{v}/morph.csv",
    params:
        settings=MORPH,
    log:
        "results/logs/morph/{v}.log",
    benchmark:
        "results/benchmarks/morph/{v}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/morph.py"


rule figure_morph:
    """Outlines of prone, supine, prone morphed onto supine and their mean; the distance left; regularity."""
    input:
        prone="results/meshes/{v}/prone.vtu",
        supine="results/meshes/{v}/supine.vtu",
        morphed="results/morph/{v}/supine.vtu",
        mean="results/morph/{v}/mean_start.vtu",
        history="results/morph/{v}/morph.csv",
        fiducials="results/registration/{v}/prone_fiducials.csv",
        library=library("figure_morph.py"),
    output:
        "results/study/figures/morph_{v}.png",
    log:
        "results/logs/figure_morph/{v}.log",
    benchmark:
        "results/benchmarks/figure_morph/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_morph.py"
