# The hanging hemisphere solved by mammosim and by other programs, on demand: each in its own Python, one thread.
PAGES["peers"] = {"tables": ["peers", "peers_targets"], "figures": ["peers"]}


rule peers_mesh:
    """The hemisphere of one element size, with or without a layer of solid elements, as every program reads it."""
    input:
        library=library("peers_mesh.py"),
    output:
        "results/peers/meshes/{edge}mm_layer_{layer}mm.npz",
    wildcard_constraints:
        edge="[0-9.]+",
        layer="[0-9.]+",
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
        adapter=lambda wildcards: str(SCRIPTS / "peers" / PROGRAMS[wildcards.program][1]),
        shared=str(SCRIPTS / "peers" / "_peer.py"),
        solver=lambda wildcards: library("peers/with_mammosim.py") if wildcards.program == "mammosim" else [],
        library=library("peer.py"),
    output:
        "results/peers/{case}/{edge}mm_{program}.csv",
    params:
        values=lambda wildcards: PEERS["cases"][wildcards.case],
        program=peer_program,
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
    """Every program in every case, and how that compares with what was aimed at."""
    input:
        rows=[
            f"results/peers/{job['case']}/{job['edge_mm']:g}mm_{program}.csv"
            for job in PEERS["runs"]
            for program in job["programs"]
        ],
        library=library("peers_table.py"),
    output:
        table="results/study/peers.csv",
        targets="results/study/peers_targets.csv",
        numbers="results/study/peers.json",
    params:
        aims=PEERS["aims"],
        stopping=STOPPING,
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
        library=library("page.py"),
    output:
        "results/study/peers.html",
    log:
        "results/logs/peers/all.log",
    benchmark:
        "results/benchmarks/peers/all.tsv"
    resources:
        mem_mb=1000,
    script:
        "../scripts/page.py"
