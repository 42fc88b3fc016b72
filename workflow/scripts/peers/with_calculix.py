"""The problem solved by CalculiX: ten-node tetrahedra, neo-Hookean, large strain, its own load steps."""

import re
import resource
import signal
import subprocess
from pathlib import Path as File
from tempfile import TemporaryDirectory

import numpy as np
from _adapter import Hemisphere, NotConverged, Path, run

INCREMENTS = 200
# CalculiX compares the largest residual force with the average force; 0.5 % unless told.
FORCE, CORRECTION = 1e-8, 1e-4
# W = C10 (I1bar - 3) + (J - 1)^2 / D1
MATERIAL = """*ELSET, ELSET=PART{i}
{elements}
*MATERIAL, NAME=LAW{i}
*HYPERELASTIC, NEO HOOKE
{C10:.12e}, {D1:.12e}
*DENSITY
{weight:.12e}
*SOLID SECTION, ELSET=PART{i}, MATERIAL=LAW{i}
"""
STEP = """*BOUNDARY
HELD, 1, 3
*STEP, NLGEOM, INC={increments}
*STATIC
{first:.6g}, 1.0
*CONTROLS, PARAMETERS=FIELD, FIELD=DISPLACEMENT
{force:g}, {correction:g}
*DLOAD
ALL, GRAV, 1.0, 0.0, 0.0, 1.0
*NODE PRINT, NSET=NODES, FREQUENCY={increments}
U
*END STEP
"""


def lines(rows: np.ndarray) -> str:
    return "\n".join(", ".join(map(str, row)) for row in rows.tolist())


class CalculiX:
    """The input as text; nodes and elements are numbered from 1."""

    def __init__(self, problem: Hemisphere) -> None:
        self.n_node = len(problem.points)
        points = [
            f"{i}, {x:.12e}, {y:.12e}, {z:.12e}" for i, (x, y, z) in enumerate(problem.points.tolist(), 1)
        ]
        cells = np.column_stack([np.arange(len(problem.cells)), problem.cells]) + 1
        parts = ["*NODE, NSET=NODES", *points, "*ELEMENT, TYPE=C3D10, ELSET=ALL", lines(cells)]
        parts += ["*NSET, NSET=HELD", lines(problem.held[:, None] + 1)]
        for i, same in enumerate(problem.same_material()):
            elements = lines(same[:, None] + 1)
            law = {"C10": problem.mu[same[0]] / 2, "D1": 2 / problem.k[same[0]], "weight": problem.weight}
            parts.append(MATERIAL.format(i=i, elements=elements, **law).rstrip())
        first = 1 / problem.load_steps
        parts.append(STEP.format(increments=INCREMENTS, first=first, force=FORCE, correction=CORRECTION))
        self.text = "\n".join(parts)

    def solve(self) -> Path:
        """The whole program: it reads its input, solves, and writes the displacements."""
        with TemporaryDirectory() as folder:
            (File(folder) / "job.inp").write_text(self.text)
            ended = subprocess.run(["ccx", "-i", "job"], cwd=folder, capture_output=True, text=True)
            steps = re.findall(r"^\s+1\s+(\d+)\s+\d+\s+(\d+)\s", _read(folder, "sta"), re.M)
            rows = np.array(
                [row.split() for row in _read(folder, "dat").splitlines() if re.match(r"\s+\d+ ", row)]
            )
        if ended.returncode == -signal.SIGXCPU:
            raise NotConverged("stopped at the limit of processor time")
        if ended.returncode or "Job finished" not in ended.stdout or len(rows) != self.n_node:
            error = re.findall(r"\*ERROR.*", ended.stdout)
            raise NotConverged(error[-1] if error else f"ccx ended with {ended.returncode}")
        iterations = len(re.findall(r"^ iteration ", ended.stdout, re.M))
        return Path(rows[np.argsort(rows[:, 0].astype(int)), 1:].astype(float), len(steps), iterations)

    def displacements(self, u: np.ndarray) -> np.ndarray:
        return u


def _read(folder: str, kind: str) -> str:
    file = File(folder) / f"job.{kind}"
    return file.read_text() if file.exists() else ""


if __name__ == "__main__":
    run(Hemisphere, CalculiX, who=resource.RUSAGE_CHILDREN)
