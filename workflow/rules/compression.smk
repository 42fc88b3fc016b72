# The breast between two rigid plates.
COMPRESSION = config["compression"]


rule compress:
    """One breast pressed to the asked thickness from its stress-free shape, frictionless, between rigid plates."""
    input:
        mesh=f"results/mechanics/{{v}}/stress_free/{STRESS_FREE['position']}_{STRESS_FREE['default']}.vtu",
        measured=f"results/meshes/{{v}}/{STRESS_FREE['position']}.vtu",
        fiducials=f"results/registration/{{v}}/{STRESS_FREE['position']}_fiducials.csv",
        library=library("compress.py"),
    output:
        shape="results/compression/{v}/{side}.vtu",
        path="results/compression/{v}/{side}_path.csv",
        faces="results/compression/{v}/{side}_faces.csv",
        strain="results/compression/{v}/{side}_strain.csv",
        plates="results/compression/{v}/{side}_plates.json",
    params:
        tissues=TISSUES,
        plate_mm=COMPRESSION["plate_mm"],
        chest_gap_mm=COMPRESSION["chest_gap_mm"],
        thickness_mm=lambda wildcards: COMPRESSION["thickness_mm"][wildcards.v],
    log:
        "results/logs/compress/{v}_{side}.log",
    benchmark:
        "results/benchmarks/compress/{v}_{side}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/compress.py"
