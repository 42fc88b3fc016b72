# Scores against the truth of digital volunteers: the only rules, with those that make them, that read it.
SEGMENTED = config["segmentation"]["positions"]


rule score_registration:
    """Millimetres and degrees between the estimated and the true rigid motion."""
    input:
        estimated="results/registration/{w}/{p}.tfm",
        steps="results/registration/{w}/{p}_steps.csv",
        fiducials=f"results/fiducials/{{w}}/{{p}}.csv",
        true_moving="results/truth/{w}/{p}_motion.tfm",
        true_fixed=lambda wildcards: f"results/truth/{wildcards.w}/{reference_of(wildcards.w)}_motion.tfm",
    output:
        "results/scores/{w}/registration_{p}.csv",
    params:
        library=library("score_registration.py"),
    log:
        "results/logs/score_registration/{w}_{p}.log",
    benchmark:
        "results/benchmarks/score_registration/{w}_{p}.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/score_registration.py"


rule score_segmentation:
    """Overlap of each tissue with the true labels."""
    input:
        labels="results/segmentation/{w}/{p}.nii.gz",
        truth="results/truth/{w}/{p}_labels.nii.gz",
    output:
        "results/scores/{w}/segmentation_{p}.csv",
    params:
        library=library("score_segmentation.py"),
    log:
        "results/logs/score_segmentation/{w}_{p}.log",
    benchmark:
        "results/benchmarks/score_segmentation/{w}_{p}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/score_segmentation.py"


rule score_stress_free:
    """Distance between the estimated and the true stress-free skin."""
    input:
        shape=lambda wildcards: unloaded_of(wildcards.w, [wildcards.method])[0],
        truth="results/truth/{w}/stress_free.vtu",
        motion=lambda wildcards: f"results/truth/{wildcards.w}/{reference_of(wildcards.w)}_motion.tfm",
    output:
        "results/scores/{w}/stress_free_{method}.csv",
    params:
        library=library("score_stress_free.py"),
    log:
        "results/logs/score_stress_free/{w}_{method}.log",
    benchmark:
        "results/benchmarks/score_stress_free/{w}_{method}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/score_stress_free.py"
