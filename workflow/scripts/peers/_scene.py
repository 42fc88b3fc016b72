"""A problem in mammosim's own terms."""

import numpy as np
from _xray import Problem

from mammosim.core.volume import Grid
from mammosim.xray.attenuation import Material
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.spectrum import Spectrum

EV_PER_KEV = 1e3


def grid_of(problem: Problem, shape: tuple[int, int, int]) -> Grid:
    """The grid of the problem's voxels."""
    facts = problem.facts
    return Grid(tuple(shape), np.array(facts["spacing_mm"]), np.array(facts["origin_mm"]))


def geometry_of(problem: Problem, source: np.ndarray) -> Geometry:
    """A source (3,) over the problem's detector."""
    d = problem.facts["detector"]
    axes = (np.array(d[name]) for name in ("origin", "u", "v"))
    return Geometry(source, Detector(*axes, tuple(d["shape"]), d["pixel_mm"]))


def scene_of(problem: Problem) -> ExposureSetup:
    """Phantom, geometry and spectrum."""
    facts, index = problem.facts, problem.arrays["index"]
    materials = [
        Material(m["name"], m["density_g_cm3"], tuple(map(tuple, m["fractions"]))) for m in facts["materials"]
    ]
    spectrum = Spectrum(np.array(facts["energies_kev"]), np.array(facts["fluence"]), facts["distance_mm"])
    geometry = geometry_of(problem, np.array(facts["source_mm"]))
    return ExposureSetup(Phantom(grid_of(problem, index.shape), index, tuple(materials)), geometry, spectrum)
