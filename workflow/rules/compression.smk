# The breast between paddle and support, by several strategies and with several sets of moduli.
COMPRESSION = config["compression"]
WAYS = checked(read_yaml(COMPRESSION["strategies_file"]), "compression", [COMPRESSION["strategies_file"]])
try:
    configuration.check_thicknesses(COMPRESSION["thickness_mm"], config["volunteers"])
except ConfigurationError as error:
    raise WorkflowError(f"ConfigurationError: {error}") from None
STRATEGIES = known_strategies(COMPRESSION["strategies"], WAYS)
MODULI = {name: TISSUES if name == "gravity" else tissue_table(name) for name in COMPRESSION["moduli"]}
XRAYED = "standard_gravity"  # what is X-rayed by default; any other strategy and set of moduli may be asked for


wildcard_constraints:
    strategy="|".join(WAYS),
    moduli="|".join(MODULI),


rule compress:
    """One breast pressed by one strategy, from its stress-free shape, without friction."""
    input:
        mesh=f"results/mechanics/{{v}}/stress_free/{STRESS_FREE['position']}_{STRESS_FREE['default']}.vtu",
        measured=f"results/meshes/{{v}}/{STRESS_FREE['position']}.vtu",
        fiducials=f"results/registration/{{v}}/{STRESS_FREE['position']}_fiducials.csv",
        standard=standard_of,
        library=library("compress.py"),
    output:
        shape="results/compression/{v}/{side}/{strategy}_{moduli}.vtu",
        row="results/compression/{v}/{side}/{strategy}_{moduli}.csv",
        path="results/compression/{v}/{side}/{strategy}_{moduli}_path.csv",
        faces="results/compression/{v}/{side}/{strategy}_{moduli}_faces.csv",
        amounts="results/compression/{v}/{side}/{strategy}_{moduli}_amounts.csv",
        thickness="results/compression/{v}/{side}/{strategy}_{moduli}_thickness.csv",
        plates="results/compression/{v}/{side}/{strategy}_{moduli}_plates.json",
    params:
        tissues=lambda wildcards: MODULI[wildcards.moduli],
        strategy=lambda wildcards: WAYS[wildcards.strategy],
        thickness_mm=lambda wildcards: COMPRESSION["thickness_mm"][wildcards.v],
        **{key: COMPRESSION[key] for key in ("smallest_mm", "steps", "penetration_mm")},
        plate_mm=COMPRESSION["plate_mm"],
        chest_gap_mm=COMPRESSION["chest_gap_mm"],
        thresholds=COMPRESSION["thresholds"],
    log:
        "results/logs/compress/{v}_{side}_{strategy}_{moduli}.log",
    benchmark:
        "results/benchmarks/compress/{v}_{side}_{strategy}_{moduli}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/compress.py"
