"""The X-ray tasks by mammosim as a user does: one call each. What kernels read is made before (`setup_s`).

The kind of the task is the last word of the command line. `plain` is region and scatter by plain transport,
without any of what lessens the variance: as many photons as energy in all tissue needs for `tissue_error`;
the time to the error wanted follows from the error reached.
"""

import sys

import numpy as np
from _adapter import Solver, XrayTask, run

from mammosim.core.volume import Grid
from mammosim.xray.attenuation import Material
from mammosim.xray.blocks import Limits
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import Primary, primary
from mammosim.xray.reconstruction import Slices, sart
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tally_request import EnergyIn, EnergyInRegions, ScatterImage
from mammosim.xray.tally_result import MaterialsResult, RegionsResult, ScatterResult, Tallies
from mammosim.xray.transport import Accuracy, transport

EV_PER_KEV = 1e3


def grid_of(problem: XrayTask, shape: tuple[int, int, int]) -> Grid:
    """The grid of the problem's voxels."""
    facts = problem.facts
    return Grid(tuple(shape), np.array(facts["spacing_mm"]), np.array(facts["origin_mm"]))


def geometry_of(problem: XrayTask, source: np.ndarray) -> Geometry:
    """A source (3,) over the problem's detector."""
    d = problem.facts["detector"]
    axes = (np.array(d[name]) for name in ("origin", "u", "v"))
    return Geometry(source, Detector(*axes, tuple(d["shape"]), d["pixel_mm"]))


def setup_of(problem: XrayTask) -> ExposureSetup:
    """Phantom, geometry and spectrum."""
    facts, index = problem.facts, problem.arrays["index"]
    materials = [
        Material(m["name"], m["density_g_cm3"], tuple(map(tuple, m["fractions"]))) for m in facts["materials"]
    ]
    spectrum = Spectrum(np.array(facts["energies_kev"]), np.array(facts["fluence"]), facts["distance_mm"])
    geometry = geometry_of(problem, np.array(facts["source_mm"]))
    return ExposureSetup(Phantom(grid_of(problem, index.shape), index, tuple(materials)), geometry, spectrum)


class View:
    """The primary image."""

    def __init__(self, problem: XrayTask) -> None:
        self.setup = setup_of(problem)

    def solve(self) -> Primary:
        return primary(self.setup.phantom, self.setup.geometry, self.setup.spectrum)

    def answer(self, solved: Primary) -> dict:
        return {"image": solved.signal}


class Transport:
    """A tally request to a beam; every run has a random stream of its own."""

    def __init__(self, problem: XrayTask) -> None:
        self.setup, self.facts, self.seed = setup_of(problem), problem.facts, 0
        self.prepared = self.setup.body, self.setup.matter
        self.request = self.quantity()

    def quantity(self) -> EnergyIn | EnergyInRegions | ScatterImage:
        return EnergyIn(self.facts["tissue"], self.facts["relative_error"])

    def solve(self) -> MaterialsResult | RegionsResult | ScatterResult:
        self.seed += 1
        return self.request.result(self.setup, seed=self.seed, limits=Limits())

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

    def __init__(self, problem: XrayTask) -> None:
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


class Plain:
    """Without any of what lessens the variance."""

    def __init__(self, problem: XrayTask) -> None:
        self.setup, self.facts, self.seed = setup_of(problem), problem.facts, 0
        self.cells = problem.arrays.get("cells")
        self.accuracy = Accuracy(self.facts["tissue"], problem.settings["tissue_error"])

    def solve(self) -> Tallies:
        self.seed += 1
        return transport(
            *(self.setup.phantom, self.setup.geometry, self.setup.spectrum),
            accuracy=self.accuracy,
            seed=self.seed,
            regions=np.array(self.facts["box_mm"])[None] if "box_mm" in self.facts else None,
            cell_mm=self.facts.get("cell_mm", 10.0),
        )

    def answer(self, solved: Tallies) -> dict:
        if self.cells is None:
            value, error = solved.regions.value, solved.regions.error
        else:
            value, error = solved.scatter.value[self.cells], solved.scatter.error[self.cells]
        seen = np.where(value > 0, value, np.nan)
        return {
            "histories": float(solved.histories),
            "value": EV_PER_KEV * float(value.sum()),
            "standard_error": EV_PER_KEV * float(np.sqrt(np.sum(error**2))),
            "reached": float(np.sqrt(np.mean((error / seen) ** 2))),
        }


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
    "plain": Plain,
}

if __name__ == "__main__":
    run(XrayTask, SOLVERS[sys.argv[5]])
