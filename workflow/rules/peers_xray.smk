# X-ray tasks by mammosim and by other programs, on demand: each in its own Python, one thread.
PAGES["peers_xray"] = {"tables": ["peers_xray", "peers_xray_targets"], "figures": ["peers_xray"]}


wildcard_constraints:
    task="|".join(XRAY_PEERS["tasks"]),


rule peers_xray_problem:
    """One X-ray task as every program reads it, and a coarse one to compile and load by."""
    input:
        library=library("peers_xray_problem.py"),
    output:
        problem="results/peers/xray/{task}.npz",
        small="results/peers/xray/{task}_small.npz",
    params:
        kind=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["kind"],
        values=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["problem"],
    log:
        "results/logs/peers_xray_problem/{task}.log",
    benchmark:
        "results/benchmarks/peers_xray_problem/{task}.tsv"
    resources:
        mem_mb=2000,
    script:
        "../scripts/peers_xray_problem.py"


rule peer_xray:
    """One program and one X-ray task: its processor time, its memory, and how far off its answer is."""
    input:
        problem="results/peers/xray/{task}.npz",
        small="results/peers/xray/{task}_small.npz",
        adapter=lambda wildcards: str(SCRIPTS / "peers" / XRAY_PROGRAMS[wildcards.program][1]),
        shared=[str(SCRIPTS / "peers" / name) for name in ("_run.py", "_xray.py", "_scene.py")],
        solver=lambda wildcards: library(f"peers/{XRAY_PROGRAMS[wildcards.program][1]}"),
        library=library("peer_xray.py"),
    output:
        "results/peers/xray/{task}_by_{program}.csv",
    params:
        kind=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["kind"],
        values=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["problem"],
        program=xray_program,
    wildcard_constraints:
        program="|".join(XRAY_PROGRAMS),
    log:
        "results/logs/peer_xray/{task}_{program}.log",
    benchmark:
        "results/benchmarks/peer_xray/{task}_{program}.tsv"
    threads: 1
    resources:
        mem_mb=3000,
    script:
        "../scripts/peer_xray.py"


rule peers_xray_table:
    """Every program and X-ray task, and how that compares with what was aimed at."""
    input:
        rows=[
            f"results/peers/xray/{name}_by_{program}.csv"
            for name, task in XRAY_PEERS["tasks"].items()
            for program in task["programs"]
        ],
        library=library("peers_xray_table.py"),
    output:
        table="results/study/peers_xray.csv",
        targets="results/study/peers_xray_targets.csv",
        numbers="results/study/peers_xray.json",
    params:
        aims=XRAY_PEERS["aims"],
    log:
        "results/logs/peers_xray_table/all.log",
    benchmark:
        "results/benchmarks/peers_xray_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/peers_xray_table.py"


rule peers_xray:
    """X-ray tasks by mammosim and by other programs, on demand: results/study/peers_xray.csv and peers_xray.html."""
    input:
        **page("peers_xray"),
        library=library("page.py"),
    output:
        "results/study/peers_xray.html",
    log:
        "results/logs/peers_xray/all.log",
    benchmark:
        "results/benchmarks/peers_xray/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
