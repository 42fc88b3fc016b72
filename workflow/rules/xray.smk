# From the compressed breast to its X-ray image and dose.
from snakemake.logging import logger

from mammosim.study.jobs.foreseen import Study, StrategyEnd, foreseen

XRAY = config["xray"]
GEOMETRY = {key: XRAY[key] for key in ("source_to_detector_mm", "support_to_detector_mm", "pixel_mm", "field_mm")}


if workflow.is_main_process:
    ends = {name: StrategyEnd.of(strategy) for name, strategy in STRATEGIES.items()}
    for words in foreseen(Study.of(config), ends, imaging_systems()):
        logger.warning(f"A result will be missing, as it seems: {words}.")
TUBE = ("anode", "filter", "filter_um", "peak_kv", "paddle")


rule phantom:
    """The compressed breast as voxels, with what was conserved on the way."""
    input:
        unpack(reads("phantom", "conservation")),
    output:
        **writes("phantom", "conservation"),
    params:
        **runs("phantom", "conservation"),
        library=library("stage.py", "phantom", "conservation"),
    log:
        "results/logs/phantom/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/phantom/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"


rule field:
    """Whether the detectors hold the compressed breast in all views: known before any photon is followed."""
    input:
        unpack(reads("field")),
    output:
        **writes("field"),
    params:
        **runs("field"),
        library=library("stage.py", "field"),
    log:
        "results/logs/field/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/field/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/stage.py"


rule spectrum:
    """The X-ray spectrum of the tube, with its half-value layer and air kerma per mAs."""
    input:
        unpack(reads("spectrum")),
    output:
        **writes("spectrum"),
    params:
        **runs("spectrum"),
        library=library("stage.py", "spectrum"),
    log:
        "results/logs/spectrum{also}.log",
    benchmark:
        "results/benchmarks/spectrum/all{also}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/stage.py"


rule beams:
    """The study's beam beside every usual target and filter: half-value layers, air kerma, spectra."""
    output:
        quality="results/study/beams.csv",
        spectra="results/study/spectra.csv",
    params:
        tube={key: XRAY[key] for key in TUBE},
        library=library("beams.py"),
    log:
        "results/logs/beams.log",
    benchmark:
        "results/benchmarks/beams/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/beams.py"


rule dose:
    """Glandular dose of one compressed breast by photon Monte Carlo, with its standard error."""
    input:
        unpack(reads("dose")),
    output:
        **writes("dose"),
    params:
        **runs("dose"),
        library=library("stage.py", "dose"),
    log:
        "results/logs/dose/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/dose/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule scatter:
    """Scatter of one compressed breast on the detector, to the asked error per cell behind it."""
    input:
        unpack(reads("scatter")),
    output:
        **writes("scatter"),
    params:
        **runs("scatter"),
        library=library("stage.py", "scatter"),
    log:
        "results/logs/scatter/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/scatter/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule mammogram:
    """The X-ray image with quantum noise, with and without the lesion, and the lesion's contrast-to-noise ratio."""
    input:
        unpack(reads("mammogram")),
    output:
        **writes("mammogram"),
    params:
        **runs("mammogram"),
        library=library("stage.py", "mammogram"),
    log:
        "results/logs/mammogram/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/mammogram/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/stage.py"


rule image_row:
    """What one mammogram shows beside the dose that it takes."""
    input:
        unpack(reads("image_row")),
    output:
        **writes("image_row"),
    params:
        **runs("image_row"),
        library=library("stage.py", "image_row"),
    log:
        "results/logs/image_row/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/image_row/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/stage.py"


rule tomosynthesis:
    """Views over the arc of a system with noise and scatter, and slices of them by two reconstructions."""
    input:
        unpack(reads("slices", "depth")),
    output:
        **writes("slices", "depth"),
    params:
        **runs("slices", "depth"),
        library=library("stage.py", "slices", "depth"),
    log:
        "results/logs/tomosynthesis/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/tomosynthesis/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/stage.py"


rule dose_routes:
    """Dose of one breast by Monte Carlo, and of its standard breast by Monte Carlo and by Dance's factors."""
    input:
        unpack(reads("dose_routes")),
    output:
        **writes("dose_routes"),
    params:
        **runs("dose_routes"),
        library=library("stage.py", "dose_routes"),
    log:
        "results/logs/dose_routes/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/dose_routes/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule dose_standard:
    """Dose of the standard breasts of 40 to 60 mm by Monte Carlo and by Dance's factors."""
    input:
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
    output:
        rows="results/study/dose_standard.csv",
    params:
        dose_error_percent=XRAY["dose_error_percent"],
        combination=f"{XRAY['anode']}/{XRAY['filter']}",
        seed=config["seed"],
        library=library("dose_standard.py"),
    log:
        "results/logs/dose_standard.log",
    benchmark:
        "results/benchmarks/dose_standard/all.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/dose_standard.py"


rule report195:
    """The photon transport beside AAPM report 195, case 3: tissue and seven regions, two beams."""
    output:
        "results/study/report195.csv",
    params:
        settings=XRAY["report195"],
        seed=config["seed"],
        library=library("report195.py"),
    log:
        "results/logs/report195.log",
    benchmark:
        "results/benchmarks/report195/all.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/report195.py"
