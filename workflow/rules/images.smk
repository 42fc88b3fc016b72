# From raw series to labelled images, all in the scanner frame of their own position.


rule check_input:
    """What is given of one position, rejected when it cannot be used; nothing else is touched then."""
    input:
        images=lambda wildcards: place_of(row(wildcards).images),
        labels=lambda wildcards: place_of(row(wildcards).labels),
        files=lambda wildcards: [*files_of(row(wildcards).images), *files_of(row(wildcards).labels)],
        codes=codes_file,
        listed=lambda wildcards: row(wildcards).fiducials or [],
        strokes=lambda wildcards: row(wildcards).strokes or [],
    output:
        "results/checked/{v}_{p}.csv",
    params:
        gravity=lambda wildcards: row(wildcards).gravity,
        chest_markers=config["registration"]["chest_markers"],
        registered=lambda wildcards: not data_of(wildcards.v).apart,
        how=lambda wildcards: series_of(row(wildcards)),
        sides=config["compression"]["sides"],
        labels=lambda wildcards: config["labels"] | {"codes": row(wildcards).codes},
        element_mm=config["mesh"]["element_mm"],
        content=lambda wildcards: content_of(row(wildcards).images, row(wildcards).labels),
        library=library("check_input.py"),
    log:
        "results/logs/check_input/{v}_{p}.log",
    benchmark:
        "results/benchmarks/check_input/{v}_{p}.tsv"
    retries: 0  # what is wrong with an input stays wrong
    resources:
        mem_mb=2000,
    script:
        "../scripts/check_input.py"


rule inputs_checked:
    """Everything that is given of the study's volunteers is usable: these jobs go before all others."""
    input:
        rows=scanned("results/checked/{v}_{p}.csv"),
    output:
        "results/checked/all.csv",
    params:
        library=library("table.py"),
    log:
        "results/logs/inputs_checked.log",
    benchmark:
        "results/benchmarks/inputs_checked/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/table.py"


rule import_image:
    """A DICOM series or image file as one volume in the patient frame LPS."""
    input:
        checked="results/checked/{v}_{p}.csv",
        others=ancient(all_of_her_checked),
        images=lambda wildcards: place_of(row(wildcards).images),
        files=lambda wildcards: files_of(row(wildcards).images),
    output:
        "results/images/{v}/{p}.nii.gz",
    params:
        how=lambda wildcards: series_of(row(wildcards)),
        content=lambda wildcards: content_of(row(wildcards).images),
        library=library("import_image.py"),
    log:
        "results/logs/import_image/{v}_{p}.log",
    benchmark:
        "results/benchmarks/import_image/{v}_{p}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/import_image.py"


rule fiducials:
    """Chest markers found in the image or taken from the list; the rest from the list, or nipples found in labels."""
    input:
        unpack(reads("fiducials")),
        checked="results/checked/{v}_{p}.csv",
        others=ancient(all_of_her_checked),
    output:
        **writes("fiducials"),
    params:
        **runs("fiducials"),
        library=library("stage.py", "fiducials"),
    log:
        "results/logs/fiducials/{v}_{p}.log",
    benchmark:
        "results/benchmarks/fiducials/{v}_{p}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule register:
    """The rigid motion of one position into the reference frame: by markers and the rib cage, or by that alone."""
    input:
        unpack(reads("transform", "moved_scan", "moved_fiducials")),
    output:
        **writes("transform", "moved_scan", "moved_fiducials"),
    params:
        **runs("transform", "moved_scan", "moved_fiducials"),
        library=library("stage.py", "transform", "moved_scan", "moved_fiducials"),
    log:
        "results/logs/register/{v}_{p}.log",
    benchmark:
        "results/benchmarks/register/{v}_{p}.tsv"
    resources:
        mem_mb=5000,
    script:
        "../scripts/stage.py"


rule segment:
    """Tissue labels of one image: from strokes by forest and active contour, without any from the image alone."""
    input:
        unpack(reads("labels", "gland_probability")),
    output:
        **writes("labels", "gland_probability"),
    params:
        **runs("labels", "gland_probability"),
        library=library("stage.py", "labels", "gland_probability"),
    wildcard_constraints:
        v=others_than(LABELLED),
    log:
        "results/logs/segment/{v}_{p}.log",
    benchmark:
        "results/benchmarks/segment/{v}_{p}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"


rule take_labels:
    """Tissue labels of one position that a person gave, in the place of a segmentation."""
    input:
        unpack(given_labels_inputs),
        files=lambda wildcards: files_of(row(wildcards).labels),
        codes=codes_file,
        checked="results/checked/{v}_{p}.csv",
        others=ancient(all_of_her_checked),
    output:
        **writes("labels"),
    params:
        **runs("labels"),
        content=lambda wildcards: content_of(row(wildcards).labels),
        library=library("stage.py", "labels"),
    wildcard_constraints:
        v=one_of(LABELLED),
    log:
        "results/logs/take_labels/{v}_{p}.log",
    benchmark:
        "results/benchmarks/take_labels/{v}_{p}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/stage.py"


rule label_colours:
    """Names and colours of the labels, once for all label maps: for 3D Slicer, and for ITK-SNAP."""
    output:
        slicer="results/segmentation/tissues.ctbl",
        snap="results/segmentation/tissues_itksnap.txt",
    params:
        library=library("label_colours.py"),
    log:
        "results/logs/label_colours.log",
    benchmark:
        "results/benchmarks/label_colours/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/label_colours.py"
