# The programs that `snakemake peers` compares: how each is run, and what to do when it is missing.
import os
import shlex
import shutil
import subprocess

PEERS = checked(read_yaml(config["peers"]), "peers", [config["peers"]])
DEBIANS_PYTHON = PEERS["debians_python"]
PEERS_PYTHON = str(HOME / ".venv-peers" / "bin" / "python")
# Program -> its Python, its adapter in workflow/scripts/peers, and the words it is given.
PROGRAMS = {
    "mammosim": (PYTHON, "with_mammosim.py", []),
    "felupe": (PEERS_PYTHON, "with_felupe.py", []),
    "dolfinx_mumps": (DEBIANS_PYTHON, "with_dolfinx.py", ["mumps"]),
    "dolfinx_gamg": (DEBIANS_PYTHON, "with_dolfinx.py", ["gamg"]),
    "ngsolve": (PEERS_PYTHON, "with_ngsolve.py", []),
    "calculix": (PYTHON, "with_calculix.py", []),
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


# X-ray: program -> its Python, its adapter, and the words it is given beside those of a user's command.
XRAY_PEERS = PEERS["xray"]
XRAY_PROGRAMS = {
    "mammosim": (PYTHON, "with_mammosim_xray.py", []),
    "plain_transport": (PYTHON, "with_mammosim_xray.py", ["plain"]),
    "gecatsim": (PEERS_PYTHON, "with_gecatsim.py", []),
    "itk_rtk_joseph": (PEERS_PYTHON, "with_itk_rtk.py", ["joseph"]),
    "itk_rtk_voxels": (PEERS_PYTHON, "with_itk_rtk.py", ["voxels"]),
    **{name: (PYTHON, "with_command.py", []) for name in XRAY_PEERS["commands"]},
}


def xray_command(program):
    """The words of a user's own command: of the environment, else of the configuration."""
    return shlex.split(os.environ.get(f"MAMMOSIM_{program.upper()}", XRAY_PEERS["commands"][program]))


def xray_missing(program):
    """What to do when a program is not installed, nothing when it is."""
    if program not in XRAY_PEERS["commands"]:
        return "" if Path(XRAY_PROGRAMS[program][0]).exists() else "make peers"
    words = xray_command(program)
    if not words:
        variable = f"MAMMOSIM_{program.upper()}"
        return f"name a command that runs it in {variable} or {config['peers']} (see docs/contracts.md)"
    return "" if shutil.which(words[0]) else f"no command {words[0]!r}"


def xray_program(wildcards):
    """How one program is run for one task."""
    program, task = wildcards.program, XRAY_PEERS["tasks"][wildcards.task]
    python, _, arguments = XRAY_PROGRAMS[program]
    if program in XRAY_PEERS["commands"]:
        arguments = xray_command(program)
    settings = {"runs": XRAY_PEERS["runs"]} | task.get("settings", {}).get(program, {})
    return {
        "python": python,
        "arguments": [task["kind"]] if program == "mammosim" else arguments,
        "missing": xray_missing(program),
        "settings": settings,
        "cpu_limit_s": XRAY_PEERS["cpu_limit_s"],
    }
