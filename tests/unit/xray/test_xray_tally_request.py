"""What is requested of a beam: each estimator with less variance has the mean of plain transport."""

import numba
import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.blocks import Limits
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import primary
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tally_request import EnergyIn, EnergyInRegions, EnergyMap, ScatterImage, results
from mammosim.xray.transport import Accuracy, transport

X, Y, Z = np.eye(3)
BEAM = Spectrum(np.array([15.0, 20.0, 25.0]), np.array([1e5, 2e5, 1e5]), 600.0)
GEOMETRY = Geometry(
    np.array([0.0, 0.0, 600.0]), Detector(np.array([-49.5, -49.5, 0.0]), X, Y, (100, 100), 1.0)
)
CORNERS = np.array([[[-10, -10, 30], [10, 10, 40]], [[20, 0, 22], [35, 20, 32]]], float)
ADIPOSE, GLAND = 1, 2


@pytest.fixture(scope="module")
def exposure() -> ExposureSetup:
    """80 x 80 x 40 mm of adipose tissue around gland, under a plate, in air."""
    grid = grid_around(np.array([-40.0, -40.0, 20.0]), np.array([40.0, 40.0, 64.0]), 4.0)
    index = np.ones(grid.shape, np.uint8)
    index[3:7, 6:14, 6:14] = GLAND
    index[10] = 3
    index[:, :, :3] = 0
    materials = tuple(material(name) for name in ("air", "adipose", "glandular", "pmma"))
    return ExposureSetup(Phantom(grid, index, materials), GEOMETRY, BEAM)


@pytest.fixture(scope="module")
def plain(exposure):
    """About two million photons."""
    accuracy = Accuracy(GLAND, 0.002)
    return transport(
        exposure.phantom, GEOMETRY, BEAM, accuracy=accuracy, seed=1, regions=CORNERS, cell_mm=20.0
    )


def deviations(a, b) -> np.ndarray:
    """Differences in standard errors of both."""
    return (a.value - b.value) / np.hypot(a.error, b.error)


def test_forced_scatter_has_the_mean_of_plain_transport(exposure, plain):
    """25 cells: their squared deviations add to chi-square of 25, below 52.6 with probability 0.999."""
    (found,) = results(exposure, [ScatterImage(GLAND, 0.01, cell_mm=20.0)], seed=2)
    assert np.sum(deviations(found.scatter, plain.scatter) ** 2) < 52.6
    assert np.sum(deviations(found.scatter_squared, plain.scatter_squared) ** 2) < 52.6
    whole = [np.sum(run.scatter.value) for run in (found, plain)]
    spread = np.sqrt(np.sum(found.scatter.error**2) + np.sum(plain.scatter.error**2))
    assert abs(whole[0] - whole[1]) < 4 * spread
    relative = (found.scatter.error / found.scatter.value)[found.requested]
    assert np.sqrt(np.mean(relative**2)) <= 0.01


def test_regions_by_rays_and_scattered_photons_have_the_mean_of_plain_transport(exposure, plain):
    (found,) = results(exposure, [EnergyInRegions(CORNERS, 0.01)], seed=3)
    assert np.all(np.abs(deviations(found.regions, plain.regions)) < 4)
    assert np.all(found.regions.error <= 0.01 * found.regions.value)
    assert found.histories < plain.histories


def test_dose_without_image_is_that_of_the_whole_transport(exposure, plain):
    (found,) = results(exposure, [EnergyIn(GLAND, 0.005)], seed=4)
    assert np.all(np.abs(deviations(found.materials, plain.materials)[1:]) < 4)
    assert found.photons_per_mas == plain.photons_per_mas


def test_a_map_holds_the_energy_of_the_body_and_its_regions(exposure, plain):
    """Cells of 8 mm tile the voxels of 4 mm; their sum is what the materials of the body hold."""
    (found,) = results(exposure, [EnergyMap(8.0, 0.01)], seed=7)
    whole, body = found.energy.value.sum(), plain.materials.value[1:].sum()
    spread = np.hypot(np.linalg.norm(found.energy.error), np.linalg.norm(plain.materials.error[1:]))
    in_air = plain.materials.value[0]  # beside the body, cells hold air
    assert body - 4 * spread < whole < body + in_air + 4 * spread
    assert np.linalg.norm(found.energy.error) <= 0.01 * np.linalg.norm(found.energy.value)
    dose = found.dose_per_mas(exposure.phantom)
    kg = 8.0**3 * material("adipose").density_g_cm3 * 1e-6
    cell = found.energy.value[0, 3, 3] * found.photons_per_mas * 1.602176634e-16 / kg * 1e3
    assert dose.value[0, 3, 3] == pytest.approx(cell, rel=1e-12)
    with pytest.raises(XrayError, match="less than a voxel"):
        results(exposure, [EnergyMap(2.0, 0.01)], seed=1)


def test_scatter_to_primary_is_scatter_over_the_projected_primary(exposure):
    (found,) = results(exposure, [ScatterImage(GLAND, 0.05, cell_mm=20.0)], seed=5)
    image = primary(exposure.phantom, GEOMETRY, BEAM).signal
    ratio = found.to_primary(image)
    here = found.per_mas(found.scatter).value[2, 2] / image[40:60, 40:60].mean()
    assert ratio.value[2, 2] == pytest.approx(here, rel=1e-12)
    with pytest.raises(XrayError, match="cannot be gathered"):
        found.to_primary(image[:99])


def test_scatter_to_primary_grows_with_thickness():
    """Of slabs of 20, 40 and 60 mm, and 0.2 to 0.9 in the middle of 40 to 60 mm (Boone and Cooper 2000)."""
    materials = tuple(material(name) for name in ("air", "adipose", "glandular"))
    ratios = []
    for thick in (20.0, 40.0, 60.0):
        grid = grid_around(np.array([-40.0, -40.0, 20.0]), np.array([40.0, 40.0, 20.0 + thick]), 4.0)
        index = np.full(grid.shape, ADIPOSE, np.uint8)
        index[:, 8:12, 8:12] = GLAND
        slab = ExposureSetup(Phantom(grid, index, materials), GEOMETRY, BEAM)
        (found,) = results(slab, [ScatterImage(GLAND, 0.03, cell_mm=20.0)], seed=10)
        ratios.append(found.to_primary(primary(slab.phantom, GEOMETRY, BEAM).signal).value[2, 2])
    assert np.all(np.diff(ratios) > 0)
    assert 0.2 < ratios[1] < ratios[2] < 0.9


@pytest.fixture
def threads_restored():
    before = numba.get_num_threads()
    yield
    numba.set_num_threads(before)


@pytest.mark.usefixtures("threads_restored")
def test_results_do_not_depend_on_the_number_of_threads(exposure):
    requests = [ScatterImage(GLAND, 0.1, cell_mm=20.0), EnergyInRegions(CORNERS, 0.1)]
    runs = []
    for threads in (1, 2):
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
        runs.append(results(exposure, requests, seed=6))
    np.testing.assert_array_equal(runs[0][0].scatter.value, runs[1][0].scatter.value)
    np.testing.assert_array_equal(runs[0][1].regions.value, runs[1][1].regions.value)


def test_turning_the_setup_by_a_right_angle_turns_its_dose(exposure):
    """A tilted source: phantom, source and detector are turned about z together, by x -> y -> -x."""
    tilted = Geometry(np.array([150.0, 0.0, 580.0]), GEOMETRY.detector)
    turned = Geometry(
        np.array([0.0, 150.0, 580.0]), Detector(np.array([49.5, -49.5, 0.0]), Y, -X, (100, 100), 1.0)
    )
    index = np.ascontiguousarray(exposure.phantom.index.transpose(0, 2, 1)[:, :, ::-1])
    other = Phantom(exposure.phantom.grid, index, exposure.phantom.materials)
    requests = [EnergyIn(GLAND, 0.005)]
    runs = [
        results(ExposureSetup(phantom, geometry, BEAM), requests, seed=seed)[0].materials
        for phantom, geometry, seed in ((exposure.phantom, tilted, 8), (other, turned, 9))
    ]
    assert np.all(np.abs(deviations(*runs)) < 4)


def test_nothing_requested_runs_nothing(exposure):
    assert results(exposure, [], seed=1, limits=Limits(1)) == []


def test_requests_that_cannot_be_met_are_rejected_or_out_of_budget(exposure):
    with pytest.raises(XrayError, match=r"needs about .* histories and .* s, but 400000"):
        results(exposure, [EnergyIn(GLAND, 1e-5)], seed=1, limits=Limits(400_000))
    with pytest.raises(XrayError, match=r"and 0.001 s are allowed"):
        results(exposure, [ScatterImage(GLAND, 1e-3)], seed=1, limits=Limits(seconds=1e-3))
    with pytest.raises(XrayError, match="allow more"):
        results(exposure, [EnergyIn(GLAND, 0.1)], seed=1, limits=Limits(1000))
    with pytest.raises(XrayError, match="no voxel has index 7"):
        results(exposure, [ScatterImage(7, 0.1)], seed=1)
    with pytest.raises(XrayError, match="casts no shadow"):
        results(exposure, [EnergyInRegions(CORNERS + [200.0, 0, 0], 0.1)], seed=1)
    with pytest.raises(XrayError, match="below its higher one"):
        EnergyInRegions(CORNERS[:, ::-1], 0.1)
    with pytest.raises(XrayError, match="outside"):
        ScatterImage(GLAND, 1.0)
