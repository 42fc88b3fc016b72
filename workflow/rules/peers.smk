# The hanging hemisphere and X-ray tasks by mammosim and by other programs, on demand: each in its own Python, one thread.
PAGES["peers"] = {"tables": ["peers", "peers_targets"], "figures": ["peers"]}
PAGES["peers_xray"] = {"tables": ["peers_xray", "peers_xray_targets"], "figures": ["peers_xray"]}


wildcard_constraints:
    task="|".join(XRAY_PEERS["tasks"]),


rule peers_mesh:
    """The hemisphere of one element size, with or without a layer of solid elements, as every program reads it."""
    output:
        "results/peers/meshes/{edge}mm_layer_{layer}mm.npz",
    wildcard_constraints:
        edge="[0-9.]+",
        layer="[0-9.]+",
    params:
        library=library("peers_mesh.py"),
    log:
        "results/logs/peers_mesh/{edge}mm_layer_{layer}mm.log",
    benchmark:
        "results/benchmarks/peers_mesh/{edge}mm_layer_{layer}mm.tsv"
    resources:
        mem_mb=1500,
    script:
        "../scripts/peers_mesh.py"


rule peer:
    """One program on one mesh in one case: its processor time, memory, path, and what it found."""
    input:
        mesh=lambda wildcards: peers_mesh_of(wildcards.case, wildcards.edge),
        coarse=lambda wildcards: peers_mesh_of(wildcards.case, f"{PEERS['warm_up_edge_mm']:g}"),
        adapter=lambda wildcards: str(HERE / "workflow" / "scripts" / "peers" / PROGRAMS[wildcards.program][1]),
        shared=str(HERE / "workflow" / "scripts" / "peers" / "_adapter.py"),
    output:
        "results/peers/{case}/{edge}mm_{program}.csv",
    params:
        values=lambda wildcards: PEERS["cases"][wildcards.case],
        program=peer_program,
        solver=lambda wildcards: library("peers/with_mammosim.py") if wildcards.program == "mammosim" else [],
        library=library("peer.py"),
    wildcard_constraints:
        case="|".join(PEERS["cases"]),
        edge="[0-9.]+",
        program="|".join(PROGRAMS),
    log:
        "results/logs/peer/{case}_{edge}mm_{program}.log",
    benchmark:
        "results/benchmarks/peer/{case}_{edge}mm_{program}.tsv"
    threads: 1
    resources:
        mem_mb=8000,
    script:
        "../scripts/peer.py"


rule peers_table:
    """Every program in every case, and how that compares with the targets."""
    input:
        rows=[
            f"results/peers/{job['case']}/{job['edge_mm']:g}mm_{program}.csv"
            for job in PEERS["runs"]
            for program in job["programs"]
        ],
    output:
        table="results/study/peers.csv",
        targets="results/study/peers_targets.csv",
        numbers="results/study/peers.json",
    params:
        targets=PEERS["targets"],
        stopping=STOPPING,
        library=library("peers_table.py"),
    log:
        "results/logs/peers_table/all.log",
    benchmark:
        "results/benchmarks/peers_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/peers_table.py"


rule peers:
    """mammosim beside other programs, on demand: peers.html, the same equilibria; peers_xray.html, the same images."""
    input:
        **page("peers"),
        xray="results/study/peers_xray.html",
    output:
        "results/study/peers.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/peers/all.log",
    benchmark:
        "results/benchmarks/peers/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"


rule peers_xray_problem:
    """One X-ray task as every program reads it, and a coarse one to compile and load by."""
    output:
        problem="results/peers/xray/{task}.npz",
        small="results/peers/xray/{task}_small.npz",
    params:
        kind=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["kind"],
        values=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["problem"],
        library=library("peers_xray_problem.py"),
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
        adapter=lambda wildcards: str(HERE / "workflow" / "scripts" / "peers" / XRAY_PROGRAMS[wildcards.program][1]),
        shared=str(HERE / "workflow" / "scripts" / "peers" / "_adapter.py"),
    output:
        "results/peers/xray/{task}_by_{program}.csv",
    params:
        kind=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["kind"],
        values=lambda wildcards: XRAY_PEERS["tasks"][wildcards.task]["problem"],
        program=xray_program,
        solver=lambda wildcards: library(f"peers/{XRAY_PROGRAMS[wildcards.program][1]}"),
        library=library("peer_xray.py"),
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
    """Every program and X-ray task, and how that compares with the targets."""
    input:
        rows=[
            f"results/peers/xray/{name}_by_{program}.csv"
            for name, task in XRAY_PEERS["tasks"].items()
            for program in task["programs"]
        ],
    output:
        table="results/study/peers_xray.csv",
        targets="results/study/peers_xray_targets.csv",
        numbers="results/study/peers_xray.json",
    params:
        targets=XRAY_PEERS["targets"],
        library=library("peers_table.py"),
    log:
        "results/logs/peers_xray_table/all.log",
    benchmark:
        "results/benchmarks/peers_xray_table/all.tsv"
    resources:
        mem_mb=500,
    script:
        "../scripts/peers_table.py"


rule peers_xray:
    """X-ray tasks by mammosim and by other programs, on demand: results/study/peers_xray.csv and peers_xray.html."""
    input:
        **page("peers_xray"),
    output:
        "results/study/peers_xray.html",
    params:
        library=library("page.py"),
    log:
        "results/logs/peers_xray/all.log",
    benchmark:
        "results/benchmarks/peers_xray/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
