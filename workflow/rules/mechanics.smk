# Equilibria under gravity: the elasticity sweep, upright with and without skin, the stress-free shape.
SWEEP = config["mechanics"]["sweep"]
UPRIGHT = config["mechanics"]["upright"]


rule sweep:
    """Supine taken as loaded, unloaded by reverse gravity, loaded prone, for one modulus."""
    input:
        mesh=f"results/meshes/{{v}}/{REFERENCE}.vtu",
        start=f"results/registration/{{v}}/{REFERENCE}_fiducials.csv",
        goal="results/registration/{v}/prone_fiducials.csv",
        transform="results/registration/{v}/prone.tfm",
    output:
        row="results/mechanics/{v}/sweep/{kpa}kpa.csv",
        shape="results/mechanics/{v}/sweep/{kpa}kpa.vtu",
    params:
        settings={key: value for key, value in SWEEP.items() if key != "youngs_modulus_kpa"},
        gravity=lambda wildcards: [gravity(wildcards.v, REFERENCE), gravity(wildcards.v, "prone")],
        library=library("sweep.py"),
    log:
        "results/logs/sweep/{v}_{kpa}kpa.log",
    benchmark:
        "results/benchmarks/sweep/{v}_{kpa}kpa.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/sweep.py"


rule upright:
    """Upright from prone, with or without skin of one modulus."""
    input:
        mesh="results/meshes/{v}/prone.vtu",
        start=lambda wildcards: in_common(wildcards.v, "prone"),
        transform=lambda wildcards: motion_of(wildcards.v, "prone"),
    output:
        row="results/mechanics/{v}/upright/skin_{skin_kpa}kpa.csv",
        shape="results/mechanics/{v}/upright/skin_{skin_kpa}kpa.vtu",
    params:
        settings={key: value for key, value in UPRIGHT.items() if key != "skin_kpa"},
        tissue={key: SWEEP[key] for key in ("poisson_ratio", "muscle_kpa", "density_g_cm3")},
        gravity=lambda wildcards: gravity(wildcards.v, "prone"),
        library=library("upright.py"),
    log:
        "results/logs/upright/{v}_{skin_kpa}kpa.log",
    benchmark:
        "results/benchmarks/upright/{v}_{skin_kpa}kpa.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/upright.py"


rule unload:
    """The shape without gravity by one method, with its residual at every iteration."""
    input:
        unpack(reads("unloaded")),
    output:
        **writes("unloaded"),
    params:
        **runs("unloaded"),
        library=library("stage.py", "unloaded"),
    wildcard_constraints:
        method="|".join({*STRESS_FREE["methods"], STRESS_FREE["default"]}),
    log:
        "results/logs/unload/{v}_{p}_{method}{also}.log",
    benchmark:
        "results/benchmarks/unload/{v}_{p}_{method}{also}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"


rule stress_free:
    """The stress-free shape that is loaded and pressed: by the default method, else by others, else with stiffer moduli."""
    input:
        unpack(reads("stress_free")),
    output:
        **writes("stress_free"),
    params:
        **runs("stress_free"),
        library=library("stage.py", "stress_free"),
    wildcard_constraints:
        p="|".join(GRAVITY),
    log:
        "results/logs/stress_free/{v}_{p}{also}.log",
    benchmark:
        "results/benchmarks/stress_free/{v}_{p}{also}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"


rule loaded:
    """The stress-free body loaded in a position."""
    input:
        unpack(reads("loaded")),
    output:
        **writes("loaded"),
    params:
        **runs("loaded"),
        library=library("stage.py", "loaded"),
    wildcard_constraints:
        position="|".join(GRAVITY),
    log:
        "results/logs/loaded/{v}_{position}{also}.log",
    benchmark:
        "results/benchmarks/loaded/{v}_{position}{also}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"
