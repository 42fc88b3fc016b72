# Quadratic tetrahedra of the soft tissue in front of the rib cage, in the reference frame.


rule mesh:
    """A closed smooth surface and quadratic tetrahedra of one segmented position, in the reference frame."""
    input:
        labels="results/segmentation/{v}/{p}.nii.gz",
        fiducials="results/fiducials/{v}/{p}.csv",
        transform="results/registration/{v}/{p}.tfm",
        library=library("mesh.py"),
    output:
        mesh="results/meshes/{v}/{p}.vtu",
        quality="results/meshes/{v}/{p}_quality.csv",
    params:
        settings=config["mesh"],
    log:
        "results/logs/mesh/{v}_{p}.log",
    benchmark:
        "results/benchmarks/mesh/{v}_{p}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/mesh.py"
