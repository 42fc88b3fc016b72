# Tables that are not the rows of all volunteers together.
MADE_BESIDE = ["trade_off", "beams", "report195", "dose_standard"]
# The report: figures and tables in one page, with every assumption and source, and what was made on demand.
PICTURES = [
    *over("positions_{v}"),
    *(f"registration_{v}_{p}" for v in WOMEN for p in moving(v)),
    *scanned("segmentation_{v}_{p}", validated),
    *over("mesh_{v}_{p}", p=SEGMENTED),
    "sweep",
    *over("upright_{v}"),
    *over("morph_{v}"),
    *over("stress_free_{v}"),
    *(f"true_stress_free_{w}" for w in DIGITAL_WOMEN),
    "convergence",
    *(["unloading"] if DIGITAL_WOMEN else []),
    *over("identification_{v}"),
    *over("fitted_shapes_{v}"),
    *(f"validation_{v}_{p}" for v in WOMEN for p in held_out(v)),
    *(["propagation"] if propagated("{v}") else []),
    *over("compression_{v}_{side}", side=COMPRESSION["sides"]),
    "curves",
    *over("thickness_{v}_{side}_{moduli}", side=COMPRESSION["sides"], moduli=MODULI),
    *over("discomfort_{v}_{side}_{moduli}", side=COMPRESSION["sides"], moduli=MODULI),
    "amounts",
    *over("phantom_{v}_{side}", side=COMPRESSION["sides"]),
    *over("mammogram_{v}_{side}", side=COMPRESSION["sides"]),
    *over("tomosynthesis_{v}_{side}", side=COMPRESSION["sides"]),
    "spectra",
    "report195",
    "dose_routes",
    "trade_off",
    "moduli",
    "gravity_and_compression",
]


rule missing:
    """What the study asked for and did not get, each reason once: the first page of the report names it."""
    input:
        tables=expand(
            "results/study/{table}.csv", table=[*(name for name, rows in TABLES.items() if rows), *MADE_BESIDE]
        ),
        pictures=expand("results/study/figures/{name}.png", name=PICTURES),
        library=library("missing.py"),
    output:
        "results/study/missing.csv",
    log:
        "results/logs/missing.log",
    benchmark:
        "results/benchmarks/missing/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/missing.py"


rule report:
    """One page with every figure and table: results/study/report.html."""
    input:
        text=str(HOME / "workflow/report/sections.yaml"),
        pictures=expand("results/study/figures/{name}.png", name=PICTURES),
        tables=expand(
            "results/study/{table}.csv", table=[*(name for name, rows in TABLES.items() if rows), *MADE_BESIDE]
        ),
        missing="results/study/missing.csv",
        quality="results/checked/all.csv",
        numbers="results/study/numbers.json",
        provenance="results/study/provenance.json",
        bibliography=str(HOME / "config/references.bib"),
        page_texts=[page_text(target) for target in PAGES],
        pages=made_pages,
        library=library("report.py"),
    output:
        "results/study/report.html",
    params:
        volunteers=WOMEN,
    log:
        "results/logs/report.log",
    benchmark:
        "results/benchmarks/report/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/report.py"
