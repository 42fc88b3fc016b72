# One position's mesh in the shape of another: what the stress-free methods start from.


rule morph:
    """Prone morphed onto the shape of supine, and the mean of the two, by the surfaces alone."""
    input:
        unpack(reads("mean_shape")),
    output:
        **writes("mean_shape"),
    params:
        **runs("mean_shape"),
        library=library("stage.py", "mean_shape"),
    log:
        "results/logs/morph/{v}{also}.log",
    benchmark:
        "results/benchmarks/morph/{v}{also}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/stage.py"
