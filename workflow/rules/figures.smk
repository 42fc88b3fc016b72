# Figures of the report, one rule each. Those that show the truth of a digital volunteer are called score_.
MODULI_HERE = {
    "sweep": [min(SWEEP["youngs_modulus_kpa"]), max(SWEEP["youngs_modulus_kpa"])],
    **{name: [tissue["youngs_modulus_kpa"]] * 2 for name, tissue in TISSUES["tissues"].items()},
    "skin": [TISSUES["skin"]["youngs_modulus_kpa"]] * 2,
}


rule figure_positions:
    """One volunteer as scanned in every position."""
    input:
        images=lambda wildcards: [f"results/images/{wildcards.v}/{p}.nii.gz" for p in imaged(wildcards.v)],
        fiducials=lambda wildcards: [f"results/fiducials/{wildcards.v}/{p}.csv" for p in imaged(wildcards.v)],
        library=library("figure_positions.py"),
    output:
        "results/study/figures/positions_{v}.png",
    params:
        gravity=lambda wildcards: {p: gravity(wildcards.v, p) for p in imaged(wildcards.v)},
    log:
        "results/logs/figure_positions/{v}.log",
    benchmark:
        "results/benchmarks/figure_positions/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_positions.py"


rule figure_registration:
    """One position over the reference position, before and after registration."""
    input:
        fixed=f"results/images/{{v}}/{REFERENCE}.nii.gz",
        moving="results/images/{v}/{p}.nii.gz",
        after="results/registration/{v}/{p}.nii.gz",
        steps="results/registration/{v}/{p}_steps.csv",
        fiducials=f"results/fiducials/{{v}}/{REFERENCE}.csv",
        library=library("figure_registration.py"),
    output:
        "results/study/figures/registration_{v}_{p}.png",
    log:
        "results/logs/figure_registration/{v}_{p}.log",
    benchmark:
        "results/benchmarks/figure_registration/{v}_{p}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_registration.py"


rule figure_segmentation:
    """Tissues over the image of one position, with their Dice overlap where the truth is known."""
    input:
        image="results/images/{v}/{p}.nii.gz",
        labels="results/segmentation/{v}/{p}.nii.gz",
        fiducials="results/fiducials/{v}/{p}.csv",
        dice=lambda wildcards: scored_of(wildcards.v, f"segmentation_{wildcards.p}"),
        library=library("figure_segmentation.py"),
    output:
        "results/study/figures/segmentation_{v}_{p}.png",
    params:
        behind_mm=XRAY["lesion"]["depth_mm"] / 2,
    log:
        "results/logs/figure_segmentation/{v}_{p}.log",
    benchmark:
        "results/benchmarks/figure_segmentation/{v}_{p}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_segmentation.py"


rule figure_mesh:
    """The mesh of one position, with its tissues on a cut."""
    input:
        mesh="results/meshes/{v}/{p}.vtu",
        fiducials=lambda wildcards: in_common(wildcards.v, wildcards.p),
        library=library("figure_mesh.py"),
    output:
        "results/study/figures/mesh_{v}_{p}.png",
    log:
        "results/logs/figure_mesh/{v}_{p}.log",
    benchmark:
        "results/benchmarks/figure_mesh/{v}_{p}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_mesh.py"


rule figure_upright:
    """One volunteer upright, with skins of several moduli."""
    input:
        measured="results/meshes/{v}/prone.vtu",
        fiducials=lambda wildcards: in_common(wildcards.v, "prone"),
        table="results/study/upright.csv",
        shapes=lambda wildcards: [
            f"results/mechanics/{wildcards.v}/upright/skin_{kpa}kpa.vtu" for kpa in UPRIGHT["skin_kpa"]
        ],
        library=library("figure_upright.py"),
    output:
        "results/study/figures/upright_{v}.png",
    params:
        skin_kpa=UPRIGHT["skin_kpa"],
    log:
        "results/logs/figure_upright/{v}.log",
    benchmark:
        "results/benchmarks/figure_upright/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_upright.py"


rule figure_stress_free:
    """The measured shape and its stress-free estimates."""
    input:
        measured=lambda wildcards: f"results/meshes/{wildcards.v}/{modelled_in(wildcards.v)}.vtu",
        fiducials=lambda wildcards: in_common(wildcards.v, modelled_in(wildcards.v)),
        shapes=lambda wildcards: stress_free_of(wildcards.v, methods_of(wildcards.v)),
        library=library("figure_stress_free.py"),
    output:
        "results/study/figures/stress_free_{v}.png",
    params:
        methods=lambda wildcards: methods_of(wildcards.v),
    log:
        "results/logs/figure_stress_free/{v}.log",
    benchmark:
        "results/benchmarks/figure_stress_free/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_stress_free.py"


rule score_shapes:
    """The measured shape, its stress-free estimates, and the true stress-free shape."""
    input:
        measured=lambda wildcards: f"results/meshes/{wildcards.w}/{modelled_in(wildcards.w)}.vtu",
        fiducials=lambda wildcards: in_common(wildcards.w, modelled_in(wildcards.w)),
        shapes=lambda wildcards: stress_free_of(wildcards.w, methods_of(wildcards.w)),
        truth="results/truth/{w}/stress_free.vtu",
        motion=lambda wildcards: f"results/truth/{wildcards.w}/{reference_of(wildcards.w)}_motion.tfm",
        library=library("figure_stress_free.py"),
    output:
        "results/study/figures/true_stress_free_{w}.png",
    params:
        methods=lambda wildcards: methods_of(wildcards.w),
    log:
        "results/logs/score_shapes/{w}.log",
    benchmark:
        "results/benchmarks/score_shapes/{w}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_stress_free.py"


rule figure_compression:
    """One breast between the plates: shape, strain, pressure."""
    input:
        shape=f"results/compression/{{v}}/{{side}}/{XRAYED}.vtu",
        plates=f"results/compression/{{v}}/{{side}}/{XRAYED}_plates.json",
        faces=f"results/compression/{{v}}/{{side}}/{XRAYED}_faces.csv",
        stress_free=lambda wildcards: stress_free_of(wildcards.v, [STRESS_FREE["default"]])[0],
        library=library("figure_compression.py"),
    output:
        "results/study/figures/compression_{v}_{side}.png",
    log:
        "results/logs/figure_compression/{v}_{side}.log",
    benchmark:
        "results/benchmarks/figure_compression/{v}_{side}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_compression.py"


rule figure_curves:
    """Force, contact area and pressure on the way of every strategy, beside what is usual in practice."""
    input:
        table="results/study/compression_path.csv",
        library=library("figure_curves.py"),
    output:
        "results/study/figures/curves.png",
    log:
        "results/logs/figure_curves/all.log",
    benchmark:
        "results/benchmarks/figure_curves/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_curves.py"


rule figure_thickness:
    """How thick one breast is everywhere under the paddle, by every strategy."""
    input:
        maps=lambda wildcards: pressed_by_all(wildcards, "_thickness.csv"),
        plates="results/compression/{v}/{side}/standard_{moduli}_plates.json",
        library=library("figure_thickness.py"),
    output:
        "results/study/figures/thickness_{v}_{side}_{moduli}.png",
    params:
        strategies=list(STRATEGIES),
    log:
        "results/logs/figure_thickness/{v}_{side}_{moduli}.log",
    benchmark:
        "results/benchmarks/figure_thickness/{v}_{side}_{moduli}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_thickness.py"


rule figure_discomfort:
    """Strain, elastic energy and pressure in one breast, by every strategy."""
    input:
        shapes=lambda wildcards: pressed_by_all(wildcards, ".vtu"),
        faces=lambda wildcards: pressed_by_all(wildcards, "_faces.csv"),
        plates="results/compression/{v}/{side}/standard_{moduli}_plates.json",
        library=library("figure_discomfort.py"),
    output:
        "results/study/figures/discomfort_{v}_{side}_{moduli}.png",
    params:
        strategies=list(STRATEGIES),
    log:
        "results/logs/figure_discomfort/{v}_{side}_{moduli}.log",
    benchmark:
        "results/benchmarks/figure_discomfort/{v}_{side}_{moduli}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_discomfort.py"


rule figure_phantom:
    """Slices through the voxels of one compressed breast."""
    input:
        labels=f"results/phantom/{{v}}/{{side}}/{XRAYED}.nii.gz",
        library=library("figure_phantom.py"),
    output:
        "results/study/figures/phantom_{v}_{side}.png",
    log:
        "results/logs/figure_phantom/{v}_{side}.log",
    benchmark:
        "results/benchmarks/figure_phantom/{v}_{side}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_phantom.py"


rule figure_mammogram:
    """The mammogram of one breast as it is read."""
    input:
        image=f"results/xray/{{v}}/{{side}}/{XRAYED}_mammogram.nii.gz",
        row=f"results/xray/{{v}}/{{side}}/{XRAYED}_image.csv",
        library=library("figure_mammogram.py"),
    output:
        "results/study/figures/mammogram_{v}_{side}.png",
    log:
        "results/logs/figure_mammogram/{v}_{side}.log",
    benchmark:
        "results/benchmarks/figure_mammogram/{v}_{side}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_mammogram.py"


rule figure_moduli:
    """Moduli in the literature and in this study."""
    input:
        fitted="results/study/identification.csv",
        library=library("figure_moduli.py"),
    output:
        "results/study/figures/moduli.png",
    params:
        here=MODULI_HERE,
    log:
        "results/logs/figure_moduli/all.log",
    benchmark:
        "results/benchmarks/figure_moduli/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_moduli.py"


rule moduli_ratio:
    """How much stiffer tissues are under compression than under gravity, in the literature and fitted here."""
    input:
        fitted="results/study/identification.csv",
        library=library("moduli_ratio.py"),
    output:
        "results/identification/ratio.csv",
    log:
        "results/logs/moduli_ratio/all.log",
    benchmark:
        "results/benchmarks/moduli_ratio/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/moduli_ratio.py"


rule figure_gravity_and_compression:
    """Moduli fitted under gravity beside those used under compression."""
    input:
        fitted="results/study/identification.csv",
        ratios="results/study/moduli_ratio.csv",
        library=library("figure_gravity_and_compression.py"),
    output:
        "results/study/figures/gravity_and_compression.png",
    log:
        "results/logs/figure_gravity_and_compression/all.log",
    benchmark:
        "results/benchmarks/figure_gravity_and_compression/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_gravity_and_compression.py"


rule figure_fitted_shapes:
    """Prone and supine as measured, the stress-free shape of the fit, and supine as the fit predicts it."""
    input:
        prone="results/meshes/{v}/prone.vtu",
        supine="results/meshes/{v}/supine.vtu",
        stress_free="results/identification/{v}/stress_free.vtu",
        predicted="results/validation/{v}/supine.vtu",
        fiducials="results/registration/{v}/prone_fiducials.csv",
        library=library("figure_fitted_shapes.py"),
    output:
        "results/study/figures/fitted_shapes_{v}.png",
    log:
        "results/logs/figure_fitted_shapes/{v}.log",
    benchmark:
        "results/benchmarks/figure_fitted_shapes/{v}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_fitted_shapes.py"


rule figure_tomosynthesis:
    """Slices of one breast pressed by the standard strategy."""
    input:
        phantom=f"results/phantom/{{v}}/{{side}}/{XRAYED}.nii.gz",
        filtered_backprojection=f"results/xray/{{v}}/{{side}}/{XRAYED}_fbp.nii.gz",
        sart=f"results/xray/{{v}}/{{side}}/{XRAYED}_sart.nii.gz",
        profiles=f"results/xray/{{v}}/{{side}}/{XRAYED}_depth.csv",
        library=library("figure_tomosynthesis.py"),
    output:
        "results/study/figures/tomosynthesis_{v}_{side}.png",
    log:
        "results/logs/figure_tomosynthesis/{v}_{side}.log",
    benchmark:
        "results/benchmarks/figure_tomosynthesis/{v}_{side}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure_tomosynthesis.py"
