# One position's mesh in the shape of another: what the stress-free methods start from.


rule morph:
    """Prone morphed onto the shape of supine, and the mean of the two, by the surfaces alone."""
    input:
        unpack(reads("mean_shape")),
        library=code("mean_shape"),
    output:
        **writes("mean_shape"),
    params:
        **runs("mean_shape"),
    log:
        "results/logs/morph/{v}{also}.log",
    benchmark:
        "results/benchmarks/morph/{v}{also}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/stage.py"


rule figure_morph:
    """Outlines of prone, supine, prone morphed onto supine and their mean; the distance left; regularity."""
    input:
        prone="results/meshes/{v}/prone.vtu",
        supine="results/meshes/{v}/supine.vtu",
        morphed="results/morph/{v}/mean_start_morphed.vtu",
        mean="results/morph/{v}/mean_start.vtu",
        history="results/morph/{v}/mean_start_history.csv",
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
