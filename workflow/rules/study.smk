# Tables of the whole study, one per stage, and the numbers that the report quotes.
NOT_PLANNED = {v: [("study of her", f"{what} is not there")] for v, what in LEFT_OUT.items()}
NOT_PLANNED |= {v: allowed.not_planned(lacking(v)) for v in WOMEN}
if workflow.is_main_process:
    for v, rows in NOT_PLANNED.items():
        if rows:
            logger.info(f"Not planned for {v}: {allowed.in_one_line(rows)}.")
TABLES = {
    "registration": scanned("results/registration/{v}/{p}_steps.csv", moving),
    "registration_error": scored("results/scores/{v}/registration_{p}.csv", moving),
    "segmentation_overlap": scored("results/scores/{v}/segmentation_{p}.csv", validated),
    "mesh_quality": scanned("results/meshes/{v}/{p}_quality.csv", meshed),
    "morph": over("results/morph/{v}/mean_start_history.csv", able("mean_shape")),
    "sweep": over("results/mechanics/{v}/sweep/{kpa}kpa.csv", able("sweep"), kpa=SWEEP["youngs_modulus_kpa"]),
    "upright": over("results/mechanics/{v}/upright/skin_{kpa}kpa.csv", able("upright"), kpa=UPRIGHT["skin_kpa"]),
    "stress_free": [
        f"results/mechanics/{v}/stress_free/{modelled_in(v)}_{method}.csv" for v in WOMEN for method in methods_of(v)
    ],
    "stress_free_attempts": [f"results/mechanics/{v}/stress_free/{modelled_in(v)}.csv" for v in able("stress_free")],
    "stress_free_error": [f"results/scores/{v}/stress_free_{method}.csv" for v in DIGITAL_WOMEN for method in methods_of(v)],
    "unloading": [f"results/scores/{v}/unloading_{kpa}kpa.csv" for v in DIGITAL_WOMEN for kpa in UNLOADING["youngs_modulus_kpa"]],
    "identification": over("results/identification/{v}/moduli.csv", able("fit")),
    "fit": over("results/identification/{v}/fit.csv", able("fit")),
    "grid": over("results/identification/{v}/grid.csv", able("fit")),
    "moduli": [f"results/scores/{v}/moduli.csv" for v in DIGITAL_WOMEN if v in able("fit")],
    "moduli_ratio": ["results/identification/ratio.csv"] if able("fit") else [],
    "validation": [f"results/validation/{v}/{p}.csv" for v in able("fit") for p in validated(v)],
    "propagation": propagated("results/propagation/{v}/rows.csv"),
    "propagation_pressed": propagated("results/propagation/{v}/pressed.csv"),
    "compression": pressed_all_ways(".csv"),
    "compression_path": pressed_all_ways("_path.csv"),
    "compression_amounts": pressed_all_ways("_amounts.csv"),
    "field": xrayed("results/xray/{v}/{side}/{strategy}_gravity_field.csv"),
    "conservation": xrayed("results/phantom/{v}/{side}/{strategy}_gravity_conservation.csv"),
    "dose": xrayed("results/xray/{v}/{side}/{strategy}_gravity_dose.csv"),
    "dose_routes": over(f"results/xray/{{v}}/{{side}}/{XRAYED}_routes.csv", able("pressed"), side=COMPRESSION["sides"]),
    "slices": over(f"results/xray/{{v}}/{{side}}/{XRAYED}_slices.csv", able("pressed"), side=COMPRESSION["sides"]),
    "image": xrayed("results/xray/{v}/{side}/{strategy}_gravity_image.csv"),
}


rule table:
    """One table of the study: the rows of all volunteers together."""
    input:
        rows=lambda wildcards: TABLES[wildcards.table],
    output:
        "results/study/{table}.csv",
    wildcard_constraints:
        table="|".join(TABLES),
    params:
        library=library("table.py"),
    log:
        "results/logs/table/{table}.log",
    benchmark:
        "results/benchmarks/table/{table}.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/table.py"


rule trade_off:
    """What a thicker breast costs: every strategy's compression beside its image and dose."""
    input:
        compression="results/study/compression.csv",
        image="results/study/image.csv",
    output:
        "results/study/trade_off.csv",
    params:
        library=library("trade_off.py"),
    log:
        "results/logs/trade_off.log",
    benchmark:
        "results/benchmarks/trade_off/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/trade_off.py"


# What the answer is taken from, where it is there.
ANSWERED = [name for name in ("compression", "compression_path", "image", "identification", "propagation") if TABLES[name]]


rule answer:
    """How far compression of each breast can be reduced, what each strategy costs, and what these data cannot say."""
    input:
        tables=expand("results/study/{table}.csv", table=ANSWERED),
        measured=home("config/accuracy/measured.csv"),
    output:
        answer="results/study/answer.csv",
        strategies="results/study/answer_strategies.csv",
        limits="results/study/answer_limits.csv",
    params:
        loss_percent=config["answer"]["loss_percent"],
        xray=XRAY,
        volunteers=WOMEN,
        known={
            "sides": COMPRESSION["sides"],
            "digital": DIGITAL_WOMEN,
            "not_planned": [[v, what, why] for v, rows in NOT_PLANNED.items() for what, why in rows],
        },
        library=library("answer.py"),
    log:
        "results/logs/answer.log",
    benchmark:
        "results/benchmarks/answer/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/answer.py"


rule numbers:
    """Every number that the report quotes, by name."""
    input:
        tables=expand("results/study/{table}.csv", table=[*(name for name, rows in TABLES.items() if rows), "answer"]),
    output:
        "results/study/numbers.json",
    params:
        library=library("collect_numbers.py"),
    log:
        "results/logs/numbers.log",
    benchmark:
        "results/benchmarks/numbers/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/collect_numbers.py"


rule provenance:
    """What made the results: versions, configuration, assumptions."""
    input:
        lock=str(HERE / "environment.lock"),
        sources=sorted(map(str, (HERE / "src" / "mammosim").rglob("*.py"))),
        numbers="results/study/numbers.json",
    output:
        "results/study/provenance.json",
    params:
        configuration=config,
        library=library("provenance.py"),
    log:
        "results/logs/provenance.log",
    benchmark:
        "results/benchmarks/provenance/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/provenance.py"
