"""Say which of the programs to compare with are missing; they come from Debian. Standard library only."""

import shutil
import subprocess
import sys

DEBIANS_PYTHON = "/usr/bin/python3"


def missing() -> list[str]:
    """Programs that are not there, each with the packages to install."""
    lines = []
    if shutil.which("ccx") is None:
        lines.append("CalculiX: apt-get install calculix-ccx")
    find = "import importlib.util, sys; sys.exit(importlib.util.find_spec('dolfinx') is None)"
    if shutil.which(DEBIANS_PYTHON) is None or subprocess.run([DEBIANS_PYTHON, "-c", find]).returncode:
        # Without OpenBLAS it factorises on the reference BLAS, several times slower.
        lines.append("dolfinx: apt-get install python3-dolfinx-real libopenblas0-pthread")
    return lines


if __name__ == "__main__":
    for line in missing():
        sys.stdout.write(f"left out of the comparison until it is installed, {line}\n")
