# Digital volunteers: virtual patients, scanned in each position. Their truth stays in results/truth.
# A woman's parameters are written once, whether they are configured or drawn; everything else follows from them.
DIGITAL_TISSUES = tissue_table(config["digital"]["tissues"])
MOVING = {"largest_deg": config["digital"]["rotation_deg"], "largest_mm": config["digital"]["translation_mm"]}


wildcard_constraints:
    w="|".join(DIGITAL),


rule digital_woman:
    """The configured parameters of a digital volunteer."""
    output:
        "results/truth/{w}/woman.json",
    params:
        woman=lambda wildcards: config["digital"]["women"][wildcards.w],
        library=library("digital_woman.py"),
    wildcard_constraints:
        w="|".join(config["digital"]["women"]),
    log:
        "results/logs/digital_woman/{w}.log",
    benchmark:
        "results/benchmarks/digital_woman/{w}.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/digital_woman.py"


rule digital_draw:
    """A digital volunteer drawn at random, and again, by name, while she has no stable state in some position."""
    output:
        woman="results/truth/{w}/woman.json",
        draws="results/truth/{w}/draws.csv",
    params:
        between=[config["digital"]["women"][w] for w in RECOVERY["between"]],
        ranges=RECOVERY["ranges"],
        draws=RECOVERY["draws"],
        positions=RECOVERY["positions"],
        tissues=DIGITAL_TISSUES,
        element_mm=config["digital"]["element_mm"],
        moving=MOVING,
        stream=lambda wildcards: [config["seed"], "made", MADE[wildcards.w]],
        library=library("digital_draw.py"),
    wildcard_constraints:
        w="|".join(MADE),
    log:
        "results/logs/digital_draw/{w}.log",
    benchmark:
        "results/benchmarks/digital_draw/{w}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/digital_draw.py"


rule digital_body:
    """The stress-free body of a digital volunteer, on a mesh of its own, and her true moduli."""
    input:
        woman="results/truth/{w}/woman.json",
    output:
        mesh="results/truth/{w}/stress_free.vtu",
        facts="results/truth/{w}/facts.json",
        moduli="results/truth/{w}/moduli.csv",
    params:
        tissues=DIGITAL_TISSUES,
        element_mm=config["digital"]["element_mm"],
        library=library("digital_body.py"),
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
        woman="results/truth/{w}/woman.json",
        mesh="results/truth/{w}/stress_free.vtu",
    output:
        mesh="results/truth/{w}/{p}.vtu",
        motion="results/truth/{w}/{p}_motion.tfm",
        points="results/truth/{w}/{p}_points.csv",
    params:
        tissues=DIGITAL_TISSUES,
        moving=MOVING,
        seed=config["seed"],
        library=library("digital_position.py"),
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
        woman="results/truth/{w}/woman.json",
        mesh="results/truth/{w}/stress_free.vtu",
        loaded="results/truth/{w}/{p}.vtu",
        motion="results/truth/{w}/{p}_motion.tfm",
        points="results/truth/{w}/{p}_points.csv",
    output:
        series=directory("results/raw/{w}/{p}"),
        fiducials="results/raw/{w}/{p}_fiducials.csv",
        strokes="results/raw/{w}/{p}_strokes.csv",
        labels="results/truth/{w}/{p}_labels.nii.gz",
    params:
        scan=config["digital"]["scan"],
        click_error_mm=config["digital"]["click_error_mm"],
        strokes=config["digital"]["strokes"],
        seed=config["seed"],
        library=library("digital_scan.py"),
    log:
        "results/logs/digital_scan/{w}_{p}.log",
    benchmark:
        "results/benchmarks/digital_scan/{w}_{p}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/digital_scan.py"
