# Every figure is a PNG for the pages and, from the same drawing, a PDF at print size beside it.
# Figures, by table: of one or two tables of the study, which a function of mammosim.figures draws (DRAWN), and of other
# files, which a function of workflow/scripts/drawn reads and draws (PICTURED).
ANSWERS = [(v, side) for v in able("pressed") for side in COMPRESSION["sides"]]
OF_ANSWERS = ["answer", "answer_strategies", "compression", "compression_path"]
DRAWN = {
    **{f"answer_{v}_{side}": ("answer.answer", OF_ANSWERS) for v, side in ANSWERS},
    "sweep": ("deformation.sweep", ["sweep"]),
    "convergence": ("unloading.convergence", ["stress_free"]),
    "unloading": ("unloading.unloading", ["unloading"]),
    "curves": ("strategies.curves", ["compression_path"]),
    "amounts": ("strategies.amounts", ["compression_amounts"]),
    "trade_off": ("dose.trade_off", ["trade_off"]),
    "propagation": ("identification.propagation", ["propagation"]),
    "spectra": ("dose.spectra", ["spectra", "beams"]),
    "dose_routes": ("dose.dose_routes", ["dose_routes", "dose_standard"]),
    "report195": ("dose.report195", ["report195"]),
    "hard_cases": ("hard_cases.hard_cases", ["hard_cases"]),
    "softening": ("identification.softening", ["softening"]),
    "effects": ("scenes.effects", ["effects"]),
    "scenes": ("scenes.scenes", ["scenes"]),
    "models": ("models.models", ["models"]),
    "recovery": ("identification.recovery", ["recovery"]),
    "moduli": ("literature.moduli", ["identification"]),
    "gravity_and_compression": ("literature.gravity_and_compression", ["identification", "moduli_ratio"]),
    "wrong_model": ("validation.wrong_model", ["wrong_model"]),
    "peers": ("peers.processor_time", ["peers"]),
    "peers_xray": ("peers.tasks", ["peers_xray", "peers_xray_targets"]),
    "accuracy_memory": ("accuracy.memory", ["accuracy"]),
    "accuracy_orders": ("accuracy.orders", ["accuracy_orders"]),
    "accuracy_budget": ("accuracy.budget", ["accuracy_budget"]),
    **{f"accuracy_{quantity}": ("accuracy.accuracy", ["accuracy"]) for quantity in ASKED},
}
# Moduli of this study that no fit found.
MODULI_HERE = {
    "sweep": [min(SWEEP["youngs_modulus_kpa"]), max(SWEEP["youngs_modulus_kpa"])],
    **{name: [tissue["youngs_modulus_kpa"]] * 2 for name, tissue in TISSUES["tissues"].items()},
    "skin": [TISSUES["skin"]["youngs_modulus_kpa"]] * 2,
}
# Settings of a figure beside its files.
FIGURE_OPTIONS = {
    **{
        f"answer_{v}_{side}": {"volunteer": v, "side": side, "loss_percent": config["answer"]["loss_percent"]}
        for v, side in ANSWERS
    },
    "moduli": {"here": MODULI_HERE},
    "convergence": {"tolerance_mm": STRESS_FREE["tolerance_mm"]},
    **{f"accuracy_{quantity}": {"quantity": quantity} for quantity in ASKED},
}


rule figure:
    """One figure of one or two tables; its function says what it shows."""
    input:
        tables=lambda wildcards: [f"results/study/{name}.csv" for name in DRAWN[wildcards.figure][1]],
    output:
        "results/study/figures/{figure}.png",
        "results/study/figures/{figure}.pdf",
    params:
        function=lambda wildcards: DRAWN[wildcards.figure][0],
        told=lambda wildcards: FIGURE_OPTIONS.get(wildcards.figure, {}),
        library=drawn_by,
    wildcard_constraints:
        figure="|".join(DRAWN),
    log:
        "results/logs/figure/{figure}.log",
    benchmark:
        "results/benchmarks/figure/{figure}.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/figure.py"


MESH = "results/meshes/{v}/{p}.vtu"
PRONE = MESH.replace("{p}", "prone")
THERE = lambda wildcards: in_common(wildcards.v, wildcards.p)
NIPPLES = lambda wildcards: in_common(wildcards.v, "prone")
PRESSED_SHAPE = f"results/compression/{{v}}/{{side}}/{XRAYED}"
XRAY_IMAGES = f"results/xray/{{v}}/{{side}}/{XRAYED}"
OF_SHAPES = {
    "measured": lambda wildcards: f"results/meshes/{wildcards.v}/{modelled_in(wildcards.v)}.vtu",
    "fiducials": lambda wildcards: in_common(wildcards.v, modelled_in(wildcards.v)),
    "shapes": lambda wildcards: unloaded_of(wildcards.v, methods_of(wildcards.v)),
}
OF_ALL_STRATEGIES = {
    "faces": lambda wildcards: pressed_by_all(wildcards, "_faces.csv"),
    "shapes": lambda wildcards: pressed_by_all(wildcards, ".vtu"),
    "plates": "results/compression/{v}/{side}/standard_{moduli}_plates.json",
}
# Figure: the function that draws it, and its files.
PICTURED = {
    "positions_{v}": (
        "volunteers.positions",
        {
            "images": lambda wildcards: [f"results/images/{wildcards.v}/{p}.nii.gz" for p in imaged(wildcards.v)],
            "fiducials": lambda wildcards: [f"results/fiducials/{wildcards.v}/{p}.csv" for p in imaged(wildcards.v)],
        },
    ),
    "registration_{v}_{p}": (
        "volunteers.registration",
        {
            "fixed": f"results/images/{{v}}/{REFERENCE}.nii.gz",
            "moving": "results/images/{v}/{p}.nii.gz",
            "after": "results/registration/{v}/{p}.nii.gz",
            "steps": "results/registration/{v}/{p}_steps.csv",
            "fiducials": f"results/fiducials/{{v}}/{REFERENCE}.csv",
        },
    ),
    "segmentation_{v}_{p}": (
        "volunteers.segmentation",
        {
            "image": "results/images/{v}/{p}.nii.gz",
            "labels": "results/segmentation/{v}/{p}.nii.gz",
            "fiducials": "results/fiducials/{v}/{p}.csv",
            "dice": lambda wildcards: scored_of(wildcards.v, f"segmentation_{wildcards.p}"),
        },
    ),
    "mesh_{v}_{p}": ("volunteers.mesh", {"mesh": MESH, "fiducials": THERE}),
    "upright_{v}": (
        "shapes.upright",
        {
            "measured": PRONE,
            "fiducials": NIPPLES,
            "table": "results/study/upright.csv",
            "shapes": [f"results/mechanics/{{v}}/upright/skin_{kpa}kpa.vtu" for kpa in UPRIGHT["skin_kpa"]],
        },
    ),
    "morph_{v}": (
        "shapes.morph",
        {
            "prone": PRONE,
            "supine": "results/meshes/{v}/supine.vtu",
            "morphed": "results/morph/{v}/mean_start_morphed.vtu",
            "mean": "results/morph/{v}/mean_start.vtu",
            "history": "results/morph/{v}/mean_start_history.csv",
            "fiducials": NIPPLES,
        },
    ),
    "stress_free_{v}": (
        "shapes.stress_free",
        OF_SHAPES
        | {
            "used": lambda wildcards: stress_free_of(wildcards.v),
            "attempts": lambda wildcards: stress_free_of(wildcards.v).replace(".vtu", ".csv"),
        },
    ),
    "true_stress_free_{v}": (
        "shapes.stress_free",
        OF_SHAPES
        | {
            "truth": "results/truth/{v}/stress_free.vtu",
            "motion": lambda wildcards: f"results/truth/{wildcards.v}/{reference_of(wildcards.v)}_motion.tfm",
        },
    ),
    "identification_{v}": (
        "fits.identification",
        {name: f"results/identification/{{v}}/{name}.csv" for name in ("grid", "history", "moduli")},
    ),
    "fitted_shapes_{v}": (
        "fits.fitted_shapes",
        {
            "prone": PRONE,
            "supine": "results/meshes/{v}/supine.vtu",
            "stress_free": "results/identification/{v}/stress_free.vtu",
            "predicted": "results/validation/{v}/supine.vtu",
            "fiducials": NIPPLES,
        },
    ),
    "validation_{v}_{p}": (
        "fits.prediction",
        {
            "shapes": lambda wildcards: [f"results/validation/{wildcards.v}/{p}.vtu" for p in validated(wildcards.v)],
            "measured": lambda wildcards: [f"results/meshes/{wildcards.v}/{p}.vtu" for p in validated(wildcards.v)],
            "fiducials": THERE,
        },
    ),
    "compression_{v}_{side}": (
        "presses.compression",
        {
            **{"shape": f"{PRESSED_SHAPE}.vtu", "plates": f"{PRESSED_SHAPE}_plates.json"},
            "faces": f"{PRESSED_SHAPE}_faces.csv",
            "stress_free": lambda wildcards: stress_free_of(wildcards.v),
        },
    ),
    "thickness_{v}_{side}_{moduli}": (
        "presses.thickness",
        {
            "maps": lambda wildcards: pressed_by_all(wildcards, "_thickness.csv"),
            "plates": OF_ALL_STRATEGIES["plates"],
        },
    ),
    "discomfort_{v}_{side}_{moduli}": ("presses.discomfort", OF_ALL_STRATEGIES),
    "pressure_{v}_{side}_{moduli}": ("presses.pressure", OF_ALL_STRATEGIES),
    "phantom_{v}_{side}": ("xrays.phantom", {"labels": f"results/phantom/{{v}}/{{side}}/{XRAYED}.nii.gz"}),
    "mammogram_{v}_{side}": (
        "xrays.mammogram",
        {"image": f"{XRAY_IMAGES}_mammogram.nii.gz", "row": f"{XRAY_IMAGES}_image.csv"},
    ),
    "tomosynthesis_{v}_{side}": (
        "xrays.tomosynthesis",
        {
            "phantom": f"results/phantom/{{v}}/{{side}}/{XRAYED}.nii.gz",
            **{"filtered_backprojection": f"{XRAY_IMAGES}_fbp.nii.gz", "sart": f"{XRAY_IMAGES}_sart.nii.gz"},
            "profiles": f"{XRAY_IMAGES}_depth.csv",
        },
    ),
}
# Settings of a figure beside its files.
MORE_OPTIONS = {
    "positions_{v}": {"gravity": lambda wildcards: {p: gravity(wildcards.v, p) for p in imaged(wildcards.v)}},
    "segmentation_{v}_{p}": {"behind_mm": XRAY["lesion"]["depth_mm"] / 2},
    "upright_{v}": {"skin_kpa": UPRIGHT["skin_kpa"]},
    **dict.fromkeys(("stress_free_{v}", "true_stress_free_{v}"), {"methods": lambda wildcards: methods_of(wildcards.v)}),
    "identification_{v}": {"prior": IDENTIFICATION["prior"]},
    "validation_{v}_{p}": {"fitted": lambda wildcards: {p: p in SEGMENTED for p in validated(wildcards.v)}},
    **{f"{name}_{{v}}_{{side}}_{{moduli}}": {"strategies": list(STRATEGIES)} for name in ("thickness", "discomfort", "pressure")},
}

for figure, (function, shown) in PICTURED.items():
    # A figure that shows the truth of a digital volunteer is a score.
    named = ("score_" if "truth" in shown else "figure_") + figure.split("_{")[0]

    rule:
        """One figure of files of results; its function says what it shows."""
        name:
            named
        input:
            **shown,
        output:
            f"results/study/figures/{figure}.png",
            f"results/study/figures/{figure}.pdf",
        params:
            **MORE_OPTIONS.get(figure, {}),
            function=function,
            library=pictured_by(function),
        log:
            f"results/logs/{named}/{figure}.log",
        benchmark:
            f"results/benchmarks/{named}/{figure}.tsv"
        resources:
            mem_mb=1000,
        script:
            "../scripts/picture.py"
