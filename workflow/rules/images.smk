# From raw series to labelled images, all in the scanner frame of their own position.


rule check_input:
    """One image and its fiducial list, refused when they cannot be used; nothing else is touched then."""
    input:
        images=lambda wildcards: row(wildcards).images,
        listed=lambda wildcards: row(wildcards).fiducials,
        library=library("check_input.py"),
    output:
        "results/checked/{v}_{p}.csv",
    params:
        gravity=lambda wildcards: row(wildcards).gravity,
        chest_markers=config["registration"]["chest_markers"],
    log:
        "results/logs/check_input/{v}_{p}.log",
    benchmark:
        "results/benchmarks/check_input/{v}_{p}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/check_input.py"


rule inputs_checked:
    """Every image and fiducial list of the study is usable: nothing else starts before."""
    input:
        rows=scanned("results/checked/{v}_{p}.csv"),
        library=library("table.py"),
    output:
        "results/checked/all.csv",
    log:
        "results/logs/inputs_checked.log",
    benchmark:
        "results/benchmarks/inputs_checked/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/table.py"


rule import_image:
    """A DICOM series or NIfTI image as one volume in the patient frame LPS."""
    input:
        checked="results/checked/{v}_{p}.csv",
        others=ancient(others_checked),
        images=lambda wildcards: row(wildcards).images,
        library=library("import_image.py"),
    output:
        "results/images/{v}/{p}.nii.gz",
    log:
        "results/logs/import_image/{v}_{p}.log",
    benchmark:
        "results/benchmarks/import_image/{v}_{p}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/import_image.py"


rule fiducials:
    """Chest markers found in the image or taken from the list; breast markers and nipples from the list."""
    input:
        unpack(reads("fiducials")),
        checked="results/checked/{v}_{p}.csv",
        others=ancient(others_checked),
        library=code("fiducials"),
    output:
        **writes("fiducials"),
    params:
        **runs("fiducials"),
    log:
        "results/logs/fiducials/{v}_{p}.log",
    benchmark:
        "results/benchmarks/fiducials/{v}_{p}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule register:
    """The rigid motion of one position into the reference frame: markers first, then the rib cage's image."""
    input:
        unpack(reads("transform", "moved_scan", "moved_fiducials")),
        library=code("transform", "moved_scan", "moved_fiducials"),
    output:
        **writes("transform", "moved_scan", "moved_fiducials"),
    params:
        **runs("transform", "moved_scan", "moved_fiducials"),
    log:
        "results/logs/register/{v}_{p}.log",
    benchmark:
        "results/benchmarks/register/{v}_{p}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule segment:
    """Tissue labels of one image from a few strokes: forest, speed image, active contour."""
    input:
        unpack(reads("labels", "gland_probability")),
        library=code("labels", "gland_probability"),
    output:
        **writes("labels", "gland_probability"),
    params:
        **runs("labels", "gland_probability"),
    log:
        "results/logs/segment/{v}_{p}.log",
    benchmark:
        "results/benchmarks/segment/{v}_{p}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"
