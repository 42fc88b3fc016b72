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
