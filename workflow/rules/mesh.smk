# Quadratic tetrahedra of the soft tissue in front of the rib cage, in the reference frame.


rule mesh:
    """A closed smooth surface and quadratic tetrahedra of one segmented position, in the reference frame."""
    input:
        unpack(reads("mesh")),
    output:
        **writes("mesh"),
    params:
        **runs("mesh"),
        library=library("stage.py", "mesh"),
    log:
        "results/logs/mesh/{v}_{p}{also}.log",
    benchmark:
        "results/benchmarks/mesh/{v}_{p}{also}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/stage.py"
