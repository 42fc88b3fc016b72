"""The X-ray tasks by mammosim as a user does: one call each. What kernels read is made before (`setup_s`)."""

import sys

import numpy as np
from _scene import EV_PER_KEV, geometry_of, grid_of, scene_of
from _xray import Problem, Solver, run

from mammosim.xray.blocks import Limits
from mammosim.xray.projector import Primary, primary
from mammosim.xray.reconstruction import Slices, sart
from mammosim.xray.tally_request import EnergyIn, EnergyInRegions, ScatterImage
from mammosim.xray.tally_result import MaterialsResult, RegionsResult, ScatterResult


class View:
    """The primary image."""

    def __init__(self, problem: Problem) -> None:
        self.scene = scene_of(problem)

    def solve(self) -> Primary:
        return primary(self.scene.phantom, self.scene.geometry, self.scene.spectrum)

    def answer(self, solved: Primary) -> dict:
        return {"image": solved.signal}


class Transport:
    """What is asked of a beam; every run has a stream of its own."""

    def __init__(self, problem: Problem) -> None:
        self.scene, self.facts, self.seed = scene_of(problem), problem.facts, 0
        self.prepared = self.scene.body, self.scene.matter
        self.asked = self.quantity()

    def quantity(self) -> EnergyIn | EnergyInRegions | ScatterImage:
        return EnergyIn(self.facts["tissue"], self.facts["relative_error"])

    def solve(self) -> MaterialsResult | RegionsResult | ScatterResult:
        self.seed += 1
        return self.asked.result(self.scene, seed=self.seed, limits=Limits())

    def answer(self, solved: MaterialsResult) -> dict:
        found, tissue = solved.materials, self.facts["tissue"]
        return energy(found.value[tissue], found.error[tissue], solved.histories)


class Region(Transport):
    def quantity(self) -> EnergyInRegions:
        return EnergyInRegions(np.array(self.facts["box_mm"])[None], self.facts["relative_error"])

    def answer(self, solved: RegionsResult) -> dict:
        return energy(solved.regions.value[0], solved.regions.error[0], solved.histories)


class Scatter(Transport):
    def quantity(self) -> ScatterImage:
        return ScatterImage(self.facts["tissue"], self.facts["relative_error"], self.facts["cell_mm"])

    def answer(self, solved: ScatterResult) -> dict:
        value, error = (a[solved.requested] for a in (solved.scatter.value, solved.scatter.error))
        reached = float(np.sqrt(np.mean((error / value) ** 2)))
        total = EV_PER_KEV * float(value.sum())
        return {"histories": float(solved.histories), "value": total, "reached": reached}


class SlicesFromViews:
    """SART; what a view sees of the grid is worked out within the call."""

    def __init__(self, problem: Problem) -> None:
        self.integrals, sources = problem.arrays["integrals"], problem.arrays["sources"]
        self.views = [geometry_of(problem, source) for source in sources]
        self.grid = grid_of(problem, problem.facts["shape"])
        self.settings = {
            "iterations": problem.facts["iterations"],
            "relaxation": problem.settings["relaxation"],
        }

    def solve(self) -> Slices:
        return sart(list(self.integrals), self.views, self.grid, **self.settings)

    def answer(self, solved: Slices) -> dict:
        return {"slices": solved.image.values}


def energy(value: float, error: float, histories: int) -> dict:
    """Per photon, in eV."""
    known = {"value": EV_PER_KEV * float(value), "standard_error": EV_PER_KEV * float(error)}
    return {"histories": float(histories), "reached": float(error / value), **known}


SOLVERS: dict[str, type[Solver]] = {
    "view": View,
    "dose": Transport,
    "region": Region,
    "scatter": Scatter,
    "slices": SlicesFromViews,
}

if __name__ == "__main__":
    run(SOLVERS[sys.argv[5]])
