# The breast between paddle and support, by several strategies and with several sets of moduli.
COMPRESSION = config["compression"]
WAYS = with_plates(
    checked(read_yaml(COMPRESSION["strategies_file"]), "compression", [COMPRESSION["strategies_file"]]),
    COMPRESSION["strategies_file"],
)
STRATEGIES = known_strategies(COMPRESSION["strategies"], WAYS)
MODULI = COMPRESSION["moduli"]
[moduli_table(name) for name in MODULI]  # each is there and complete
XRAYED = "standard_gravity"  # what is X-rayed by default; any other strategy and set of moduli may be asked for


wildcard_constraints:
    strategy="|".join(WAYS),
    moduli="|".join({"gravity", *MODULI, *stems("config/tissues")}),


rule standard_path:
    """The load path of the standard strategy from the stress-free shape, which the other strategies go on from."""
    input:
        unpack(reads("standard_path")),
    output:
        **writes("standard_path"),
    params:
        **runs("standard_path"),
        library=library("stage.py", "standard_path"),
    log:
        "results/logs/standard_path/{v}_{side}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/standard_path/{v}_{side}_{moduli}{also}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"


rule compress:
    """One breast pressed by one strategy: shape, load path, thickness, strain, pressure."""
    input:
        unpack(reads("pressed")),
    output:
        **writes("pressed"),
    params:
        **runs("pressed"),
        library=library("stage.py", "pressed"),
    log:
        "results/logs/compress/{v}_{side}_{strategy}_{moduli}{also}.log",
    benchmark:
        "results/benchmarks/compress/{v}_{side}_{strategy}_{moduli}{also}.tsv"
    resources:
        mem_mb=4000,
    script:
        "../scripts/stage.py"
