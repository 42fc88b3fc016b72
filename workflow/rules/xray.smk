# From the compressed breast to its X-ray image and dose.
from snakemake.logging import logger

from mammosim.io.tabulated import tabulated
from mammosim.study.jobs.foreseen import foreseen

XRAY = config["xray"]
MEASURED = STRESS_FREE["position"]
GEOMETRY = {
    key: XRAY[key] for key in ("source_to_detector_mm", "support_to_detector_mm", "pixel_mm", "field_mm")
}

known_strategies(XRAY["strategies"], STRATEGIES)  # what is X-rayed is compressed
if workflow.is_main_process:
    for words in foreseen(config, STRATEGIES, tabulated("imaging_systems").set_index("system").to_dict("index")):
        logger.warning(f"A result will be missing, as it seems: {words}.")
SCATTERED = "scatter" in XRAY["effects"]
TUBE = ("anode", "filter", "filter_um", "peak_kv", "paddle")
CHAIN = ("detector", "focal_spot_mm", "grid", "structure_percent", *TUBE)


rule phantom:
    """The compressed breast as voxels, with what was conserved on the way."""
    input:
        shape="results/compression/{v}/{side}/{strategy}_{moduli}.vtu",
        measured=f"results/meshes/{{v}}/{MEASURED}.vtu",
        labels=f"results/segmentation/{{v}}/{MEASURED}.nii.gz",
        transform=f"results/registration/{{v}}/{MEASURED}.tfm",
        fiducials=f"results/registration/{{v}}/{MEASURED}_fiducials.csv",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        library=library("phantom.py"),
    output:
        labels="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        conservation="results/phantom/{v}/{side}/{strategy}_{moduli}_conservation.csv",
    params:
        voxel_mm=XRAY["voxel_mm"],
        lesion=XRAY["lesion"],
        skin_mm=TISSUES["skin"]["thickness_mm"],
        density_g_cm3={name: tissue["density_g_cm3"] for name, tissue in TISSUES["tissues"].items()},
    log:
        "results/logs/phantom/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/phantom/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/phantom.py"


rule field:
    """Whether the detectors hold the compressed breast in all views: known before any photon is followed."""
    input:
        phantom="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        library=library("field.py"),
    output:
        rows="results/xray/{v}/{side}/{strategy}_{moduli}_field.csv",
    params:
        geometry=GEOMETRY,
        scan={key: XRAY["tomosynthesis"][key] for key in ("system", "pixel_mm")},
    log:
        "results/logs/field/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/field/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/field.py"


rule spectrum:
    """The X-ray spectrum of the tube, with its half-value layer and air kerma per mAs."""
    input:
        library=library("spectrum.py"),
    output:
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
    params:
        tube={key: XRAY[key] for key in (*TUBE, "energies")},
    log:
        "results/logs/spectrum.log",
    benchmark:
        "results/benchmarks/spectrum/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/spectrum.py"


rule beams:
    """The study's beam beside every usual target and filter: half-value layers, air kerma, spectra."""
    input:
        library=library("beams.py"),
    output:
        quality="results/study/beams.csv",
        spectra="results/xray/beams.csv",
    params:
        tube={key: XRAY[key] for key in TUBE},
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
        phantom="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        field="results/xray/{v}/{side}/{strategy}_{moduli}_field.csv",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
        library=library("dose.py"),
    output:
        dose="results/xray/{v}/{side}/{strategy}_{moduli}_dose.csv",
    params:
        geometry=GEOMETRY,
        dose_error_percent=XRAY["dose_error_percent"],
        seed=config["seed"],
    log:
        "results/logs/dose/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/dose/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/dose.py"


rule scatter:
    """Scatter of one compressed breast on the detector, to the asked error per cell behind it."""
    input:
        phantom="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        field="results/xray/{v}/{side}/{strategy}_{moduli}_field.csv",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
        library=library("scatter.py"),
    output:
        scatter="results/xray/{v}/{side}/{strategy}_{moduli}_scatter.csv",
    params:
        geometry=GEOMETRY,
        scatter_error_percent=XRAY["scatter_error_percent"],
        scatter_pixel_mm=XRAY["scatter_pixel_mm"],
        seed=config["seed"],
    log:
        "results/logs/scatter/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/scatter/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/scatter.py"


rule mammogram:
    """The X-ray image with quantum noise, with and without the lesion, and the lesion's contrast-to-noise ratio."""
    input:
        phantom="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        field="results/xray/{v}/{side}/{strategy}_{moduli}_field.csv",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
        scatter=["results/xray/{v}/{side}/{strategy}_{moduli}_scatter.csv"] if SCATTERED else [],
        dose="results/xray/{v}/{side}/{strategy}_{moduli}_dose.csv",
        library=library("mammogram.py"),
    output:
        image="results/xray/{v}/{side}/{strategy}_{moduli}_mammogram.nii.gz",
        row="results/xray/{v}/{side}/{strategy}_{moduli}_image.csv",
    params:
        geometry=GEOMETRY,
        detector_kerma_ugy=XRAY["detector_kerma_ugy"],
        rays_per_pixel=XRAY["rays_per_pixel"],
        effects=XRAY["effects"],
        chain={key: XRAY[key] for key in CHAIN},
        calcifications=XRAY["calcifications"],
        seed=config["seed"],
    log:
        "results/logs/mammogram/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/mammogram/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/mammogram.py"


rule tomosynthesis:
    """Views over the arc of a system with noise and scatter, and slices of them by two reconstructions."""
    input:
        phantom="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        field="results/xray/{v}/{side}/{strategy}_{moduli}_field.csv",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
        image="results/xray/{v}/{side}/{strategy}_{moduli}_image.csv",
        library=library("tomosynthesis.py"),
    output:
        filtered_backprojection="results/xray/{v}/{side}/{strategy}_{moduli}_fbp.nii.gz",
        sart="results/xray/{v}/{side}/{strategy}_{moduli}_sart.nii.gz",
        profiles="results/xray/{v}/{side}/{strategy}_{moduli}_depth.csv",
        rows="results/xray/{v}/{side}/{strategy}_{moduli}_slices.csv",
    params:
        scan=XRAY["tomosynthesis"],
        scatter_pixel_mm=XRAY["scatter_pixel_mm"],
        scatter_error_percent=XRAY["scatter_error_percent"],
        effects=XRAY["effects"],
        chain={key: XRAY[key] for key in CHAIN},
        seed=config["seed"],
    log:
        "results/logs/tomosynthesis/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/tomosynthesis/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=3000,
    script:
        "../scripts/tomosynthesis.py"


rule dose_routes:
    """Dose of one breast by Monte Carlo, and of its standard breast by Monte Carlo and by Dance's factors."""
    input:
        phantom="results/phantom/{v}/{side}/{strategy}_{moduli}.nii.gz",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
        dose="results/xray/{v}/{side}/{strategy}_{moduli}_dose.csv",
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
        library=library("dose_routes.py"),
    output:
        rows="results/xray/{v}/{side}/{strategy}_{moduli}_routes.csv",
    params:
        dose_error_percent=XRAY["dose_error_percent"],
        combination=f"{XRAY['anode']}/{XRAY['filter']}",
        seed=config["seed"],
    log:
        "results/logs/dose_routes/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/dose_routes/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/dose_routes.py"


rule dose_standard:
    """Dose of the standard breasts of 40 to 60 mm by Monte Carlo and by Dance's factors."""
    input:
        spectrum="results/xray/spectrum.csv",
        facts="results/xray/spectrum.json",
        library=library("dose_standard.py"),
    output:
        rows="results/study/dose_standard.csv",
    params:
        dose_error_percent=XRAY["dose_error_percent"],
        combination=f"{XRAY['anode']}/{XRAY['filter']}",
        seed=config["seed"],
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
    input:
        library=library("report195.py"),
    output:
        "results/study/report195.csv",
    params:
        settings=XRAY["report195"],
        seed=config["seed"],
    log:
        "results/logs/report195.log",
    benchmark:
        "results/benchmarks/report195/all.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/report195.py"
