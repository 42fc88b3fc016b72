# Digital volunteers: made women, scanned in each position. Their truth stays in results/truth.
DIGITAL_TISSUES = tissue_table(config["digital"]["tissues"])


wildcard_constraints:
    w="|".join(config["digital"]["women"]),


rule digital_body:
    """The stress-free body of a digital volunteer, on a mesh of its own."""
    input:
        library=library("digital_body.py"),
    output:
        mesh="results/truth/{w}/stress_free.vtu",
        facts="results/truth/{w}/facts.json",
    params:
        woman=lambda wildcards: config["digital"]["women"][wildcards.w],
        element_mm=config["digital"]["element_mm"],
    log:
        "results/logs/digital_body/{w}.log",
    benchmark:
        "results/benchmarks/digital_body/{w}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/digital_body.py"


rule digital_position:
    """A digital volunteer in one position: moved rigidly and loaded by gravity."""
    input:
        mesh="results/truth/{w}/stress_free.vtu",
        library=library("digital_position.py"),
    output:
        mesh="results/truth/{w}/{p}.vtu",
        motion="results/truth/{w}/{p}_motion.tfm",
        points="results/truth/{w}/{p}_points.csv",
    params:
        woman=lambda wildcards: config["digital"]["women"][wildcards.w],
        tissues=DIGITAL_TISSUES,
        rotation_deg=config["digital"]["rotation_deg"],
        translation_mm=config["digital"]["translation_mm"],
        seed=config["seed"],
    log:
        "results/logs/digital_position/{w}_{p}.log",
    benchmark:
        "results/benchmarks/digital_position/{w}_{p}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/digital_position.py"


rule digital_scan:
    """The MR scan of a digital volunteer: a DICOM series, and what a person would click and paint on it."""
    input:
        mesh="results/truth/{w}/stress_free.vtu",
        loaded="results/truth/{w}/{p}.vtu",
        motion="results/truth/{w}/{p}_motion.tfm",
        points="results/truth/{w}/{p}_points.csv",
        library=library("digital_scan.py"),
    output:
        series=directory("results/raw/{w}/{p}"),
        fiducials="results/raw/{w}/{p}_fiducials.csv",
        strokes="results/raw/{w}/{p}_strokes.csv",
        labels="results/truth/{w}/{p}_labels.nii.gz",
    params:
        woman=lambda wildcards: config["digital"]["women"][wildcards.w],
        scan=config["digital"]["scan"],
        click_error_mm=config["digital"]["click_error_mm"],
        strokes=config["digital"]["strokes"],
        seed=config["seed"],
    log:
        "results/logs/digital_scan/{w}_{p}.log",
    benchmark:
        "results/benchmarks/digital_scan/{w}_{p}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/digital_scan.py"
