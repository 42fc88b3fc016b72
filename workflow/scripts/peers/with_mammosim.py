"""The problem solved by mammosim as a user does: one call, which chooses its solver and its steps."""

import numpy as np
from _adapter import Hemisphere, NotConverged, Path, run

from mammosim.core.errors import EquilibriumError
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import tissues_by_label
from mammosim.mechanics.body import Skin, load
from mammosim.mechanics.equilibrium import Settings
from mammosim.mechanics.newton import NewtonSettings

GRAVITY = np.array([0.0, 0.0, 1.0])


class Mammosim:
    def __init__(self, problem: Hemisphere) -> None:
        self.mesh = TetMesh(problem.points, problem.cells, problem.tissue, problem.boundaries)
        self.tissues = tissues_by_label(problem.case["tissues"])
        self.skin = Skin(**problem.case["membrane"]) if problem.case["membrane"] else None
        self.settings = Settings(NewtonSettings(tolerance=problem.tolerance))

    def solve(self) -> Path:
        try:
            found = load(self.mesh, self.tissues, GRAVITY, skin=self.skin, settings=self.settings)
        except EquilibriumError as failure:
            raise NotConverged(str(failure)) from None
        factors = {iteration.load_factor for iteration in found.history}
        steps = sum(iteration.step_length > 0 for iteration in found.history)
        return Path(found.points - self.mesh.points, len(factors), steps)

    def displacements(self, u: np.ndarray) -> np.ndarray:
        return u


if __name__ == "__main__":
    run(Hemisphere, Mammosim)
