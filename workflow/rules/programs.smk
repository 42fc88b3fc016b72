# The programs that `snakemake peers` compares: how each is run, and what to do when it is missing.
import shutil
import subprocess
import sys

PEERS = checked(read_yaml(config["peers"]), "peers", [config["peers"]])
DEBIANS_PYTHON = PEERS["debians_python"]
PEERS_PYTHON = str(HOME / ".venv-peers" / "bin" / "python")
# Program -> its Python, its adapter in workflow/scripts/peers, and the words it is given.
PROGRAMS = {
    "mammosim": (sys.executable, "with_mammosim.py", []),
    "felupe": (PEERS_PYTHON, "with_felupe.py", []),
    "dolfinx_mumps": (DEBIANS_PYTHON, "with_dolfinx.py", ["mumps"]),
    "dolfinx_gamg": (DEBIANS_PYTHON, "with_dolfinx.py", ["gamg"]),
    "ngsolve": (PEERS_PYTHON, "with_ngsolve.py", []),
    "calculix": (sys.executable, "with_calculix.py", []),
    "scikit_fem": (PEERS_PYTHON, "with_scikit_fem.py", []),
}
OWN_RESIDUAL = "residual over weight"
STOPPING = {
    "mammosim": OWN_RESIDUAL,
    "felupe": "residual over reactions",
    "dolfinx_mumps": "residual over the residual that a load step begins with",
    "dolfinx_gamg": "residual over the residual that a load step begins with",
    "ngsolve": "energy norm of the last correction",
    "calculix": "largest residual over the average force; displacements have seven digits",
    "scikit_fem": OWN_RESIDUAL,
}


def missing(program):
    """What to do when a program is not installed, nothing when it is."""
    if program == "calculix":
        return "" if shutil.which("ccx") else "apt-get install calculix-ccx"
    python = PROGRAMS[program][0]
    if python == PEERS_PYTHON:
        return "" if Path(python).exists() else "make peers"
    if python == DEBIANS_PYTHON:
        find = "import importlib.util, sys; sys.exit(importlib.util.find_spec('dolfinx') is None)"
        there = Path(python).exists() and subprocess.run([python, "-c", find]).returncode == 0
        return "" if there else "apt-get install python3-dolfinx-real libopenblas0-pthread"
    return ""


def peers_mesh_of(case, edge):
    """The mesh of a case: with its layer of solid elements, if it has one."""
    layer = PEERS["cases"][case].get("layer", {}).get("thickness_mm", 0)
    return f"results/peers/meshes/{edge}mm_layer_{layer:g}mm.npz"


def peer_program(wildcards):
    """How one program is run."""
    python, _, arguments = PROGRAMS[wildcards.program]
    steps = PEERS["cases"][wildcards.case].get("load_steps", {}).get(wildcards.program, 1)
    return {
        "python": python,
        "arguments": arguments,
        "missing": missing(wildcards.program),
        "settings": {"tolerance": PEERS["tolerance"], "load_steps": steps},
        "cpu_limit_s": PEERS["cpu_limit_s"],
    }
