# Tables that are not the rows of all volunteers together.
PRESSED = bool(able("pressed"))
MADE_BESIDE = [
    "answer",
    "answer_strategies",
    "answer_limits",
    *(["trade_off"] if PRESSED else []),
    "beams",
    "report195",
    "dose_standard",
]
# The report: figures and tables in one page, with every assumption and source, and what was made on demand.
PICTURES = [
    *over("answer_{v}_{side}", able("pressed"), side=COMPRESSION["sides"]),
    *(f"positions_{v}" for v in WOMEN if imaged(v)),
    *(f"registration_{v}_{p}" for v in WOMEN for p in moving(v)),
    *(f"segmentation_{v}_{p}" for v in WOMEN for p in validated(v) if p in imaged(v)),
    *scanned("mesh_{v}_{p}", meshed),
    *(["sweep"] if able("sweep") else []),
    *over("upright_{v}", able("upright")),
    *over("morph_{v}", able("mean_shape")),
    *over("stress_free_{v}", able("stress_free")),
    *(f"true_stress_free_{w}" for w in DIGITAL_WOMEN),
    *(["convergence"] if able("stress_free") else []),
    *(["unloading"] if DIGITAL_WOMEN else []),
    *over("identification_{v}", able("fit")),
    *over("fitted_shapes_{v}", able("fit")),
    *(f"validation_{v}_{p}" for v in able("validation") for p in held_out(v)),
    *(["propagation"] if propagated("{v}") else []),
    *over("compression_{v}_{side}", able("pressed"), side=COMPRESSION["sides"]),
    *(["curves"] if PRESSED else []),
    *over("thickness_{v}_{side}_{moduli}", able("pressed"), side=COMPRESSION["sides"], moduli=MODULI),
    *over("discomfort_{v}_{side}_{moduli}", able("pressed"), side=COMPRESSION["sides"], moduli=MODULI),
    *over("pressure_{v}_{side}_{moduli}", able("pressed"), side=COMPRESSION["sides"], moduli=MODULI),
    *(["amounts"] if PRESSED else []),
    *over("phantom_{v}_{side}", able("pressed"), side=COMPRESSION["sides"]),
    *over("mammogram_{v}_{side}", able("pressed"), side=COMPRESSION["sides"]),
    *over("tomosynthesis_{v}_{side}", able("pressed"), side=COMPRESSION["sides"]),
    "spectra",
    "report195",
    *(["dose_routes"] if PRESSED else []),
    *(["trade_off"] if PRESSED else []),
    *(["moduli", "gravity_and_compression"] if able("fit") else []),
]


rule missing:
    """What the study asked for and did not get, each reason once: the first page of the report names it."""
    input:
        tables=expand("results/study/{table}.csv", table=[*(name for name, rows in TABLES.items() if rows), *MADE_BESIDE]),
        pictures=expand("results/study/figures/{name}.png", name=PICTURES),
    output:
        "results/study/missing.csv",
    params:
        library=library("missing.py"),
    log:
        "results/logs/missing.log",
    benchmark:
        "results/benchmarks/missing/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/missing.py"


rule not_planned:
    """What the data of each volunteer do not allow, and why: no failure, and nobody waits for it."""
    output:
        "results/study/not_planned.csv",
    params:
        rows=[(v, what, why) for v, rows in NOT_PLANNED.items() for what, why in rows],
        library=library("not_planned.py"),
    log:
        "results/logs/not_planned.log",
    benchmark:
        "results/benchmarks/not_planned/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/not_planned.py"


rule page_scripts:
    """Scripts by which tables sort and bodies turn, from the packages that bring them: results/study/scripts."""
    output:
        PAGE_SCRIPTS,
    params:
        library=library("page_scripts.py"),
    log:
        "results/logs/page_scripts.log",
    benchmark:
        "results/benchmarks/page_scripts/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/page_scripts.py"


rule report:
    """A page with every figure and table, which reads from a file: results/study/report.html and what is beside it."""
    input:
        text=str(HERE / "workflow/report/sections.yaml"),
        pictures=expand("results/study/figures/{name}.png", name=PICTURES),
        tables=expand("results/study/{table}.csv", table=[*(name for name, rows in TABLES.items() if rows), *MADE_BESIDE]),
        missing="results/study/missing.csv",
        not_planned="results/study/not_planned.csv",
        quality="results/checked/all.csv",
        numbers="results/study/numbers.json",
        provenance="results/study/provenance.json",
        bibliography=str(HERE / "config/references.bib"),
        page_texts=[page_text(target) for target in PAGES],
        questions=str(HERE / "workflow/questions.yaml"),
        pages=made_pages,
        scripts=PAGE_SCRIPTS,
    output:
        page="results/study/report.html",
        cost="results/study/figures/cost.png",
        cost_print="results/study/figures/cost.pdf",
    params:
        volunteers=WOMEN,
        lacking=[*(what for what in allowed.REPORTED if not able(what)), *(["truth"] if not DIGITAL_WOMEN else [])],
        library=library("report.py"),
    log:
        "results/logs/report.log",
    benchmark:
        "results/benchmarks/report/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/report.py"
