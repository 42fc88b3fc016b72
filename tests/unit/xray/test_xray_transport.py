"""Photon transport: energy, errors, streams, and what is rejected."""

import numba
import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.dose import air_kerma_at, mean_glandular_dose
from mammosim.xray.exposure_setup import bounding_boxes
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import primary
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.transport import Accuracy, transport
from mammosim.xray.views import mammography_geometry

X, Y, Z = np.eye(3)
BEAM = Spectrum(np.array([15.0, 20.0, 25.0]), np.array([1e5, 2e5, 1e5]), 600.0)
GEOMETRY = Geometry(
    np.array([0.0, 0.0, 600.0]), Detector(np.array([-49.5, -49.5, 0.0]), X, Y, (100, 100), 1.0)
)
ROUGH = Accuracy(2, 0.02, block=1000)


def block() -> Phantom:
    """80 x 80 x 40 mm of adipose tissue around glandular tissue."""
    grid = grid_around(np.array([-40.0, -40.0, 20.0]), np.array([40.0, 40.0, 60.0]), 4.0)
    index = np.ones(grid.shape, np.uint8)
    index[3:7, 6:14, 6:14] = 2
    return Phantom(grid, index, (material("air"), material("adipose"), material("glandular")))


def test_energy_in_is_energy_out():
    run = transport(block(), GEOMETRY, BEAM, accuracy=ROUGH, seed=1)
    assert abs(run.lost_kev) < 1e-12 * run.emitted_kev
    assert run.materials.value.min() > 0
    assert run.escaped_kev > 0


@pytest.fixture
def threads_restored():
    before = numba.get_num_threads()
    yield
    numba.set_num_threads(before)


@pytest.mark.usefixtures("threads_restored")
def test_tallies_do_not_depend_on_the_number_of_threads():
    runs = []
    for threads in (1, 2):
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
        runs.append(transport(block(), GEOMETRY, BEAM, accuracy=ROUGH, seed=1))
    for name in ("materials", "primary", "scatter"):
        np.testing.assert_array_equal(getattr(runs[0], name).value, getattr(runs[1], name).value)


def test_another_seed_gives_other_numbers_within_their_errors():
    a, b = (transport(block(), GEOMETRY, BEAM, accuracy=ROUGH, seed=seed).materials for seed in (1, 2))
    assert np.all(a.value != b.value)
    assert np.all(np.abs(a.value - b.value) < 4 * np.hypot(a.error, b.error))


def test_transport_runs_until_the_asked_error():
    run = transport(block(), GEOMETRY, BEAM, accuracy=Accuracy(2, 0.01, block=1000), seed=3)
    assert run.materials.error[2] <= 0.01 * run.materials.value[2]


def test_regions_that_tile_the_body_hold_its_energy():
    halves = np.array([[[-40, -40, 20], [40, 40, 40]], [[-40, -40, 40], [40, 40, 60]]], float)
    run = transport(block(), GEOMETRY, BEAM, accuracy=ROUGH, seed=4, regions=halves)
    assert run.regions.value.sum() == pytest.approx(run.materials.value[1:].sum(), rel=1e-12)


def test_free_paths_are_exponential():
    """Behind the block, in one cell, as many photons have met nothing as Beer-Lambert says: exp(-mu t)."""
    run = transport(block(), GEOMETRY, BEAM, accuracy=Accuracy(2, 0.005), seed=5, cell_mm=100.0)
    # one ray per pixel of 1 mm would miss the corners of the block by 0.4 percent
    exact = primary(block(), GEOMETRY, BEAM, supersampling=8).signal.mean()
    counted = run.per_mas(run.primary)
    assert abs(counted.value[0, 0] - exact) < 4 * counted.error[0, 0]
    assert counted.error[0, 0] < 0.01 * exact


def test_a_detector_beside_the_chest_below_the_breast_is_seen():
    """The chest reaches below the detector's plane, in a box with the breast; all the primary arrives."""
    grid = grid_around(np.array([-60.0, -80.0, -100.0]), np.array([60.0, 40.0, 100.0]), 4.0)
    y, z = grid.centres()[:, 1].reshape(grid.shape), grid.centres()[:, 2].reshape(grid.shape)
    index = np.where((y > 2) | ((z > 0) & (z < 40)), 1, 0).astype(np.uint8)
    index[26:34, 8:14, 12:18] = 2
    phantom = Phantom(grid, index, block().materials)
    geometry = mammography_geometry(phantom, chest_wall_y_mm=2.0, field_mm=(100.0, 140.0))
    run = transport(phantom, geometry, BEAM, accuracy=Accuracy(2, 0.01), seed=6, cell_mm=20.0)
    exact = primary(phantom, geometry, BEAM).signal.reshape(5, 20, 7, 20).mean(axis=(1, 3))
    counted = run.per_mas(run.primary)
    assert np.all(np.abs(counted.value - exact) < 5 * counted.error)
    assert abs(run.lost_kev) < 1e-12 * run.emitted_kev


def test_impossible_runs_are_rejected():
    with pytest.raises(XrayError, match="no voxel has index 3"):
        transport(block(), GEOMETRY, BEAM, accuracy=Accuracy(3, 0.02), seed=1)
    with pytest.raises(XrayError, match="raise it, or accept"):
        transport(block(), GEOMETRY, BEAM, accuracy=Accuracy(2, 1e-4, 40_000, 1000), seed=1)
    with pytest.raises(XrayError, match="relative_error = 0 is outside"):
        Accuracy(1, 0)
    with pytest.raises(XrayError, match="allow more"):
        Accuracy(1, 0.01, max_histories=100)
    inside = Geometry(GEOMETRY.source, Detector(np.array([-49.5, -49.5, 30.0]), X, Y, (100, 100), 1.0))
    with pytest.raises(XrayError, match="detector is inside the body"):
        transport(block(), inside, BEAM, accuracy=ROUGH, seed=1)
    with pytest.raises(XrayError, match="source is inside the body"):
        transport(block(), Geometry(np.array([0, 0, 50.0]), GEOMETRY.detector), BEAM, accuracy=ROUGH, seed=1)


def test_dose_is_energy_over_mass_and_scales_with_the_beam():
    phantom = block()
    run = transport(phantom, GEOMETRY, BEAM, accuracy=ROUGH, seed=1)
    K = air_kerma_at(np.array([0, 0, 60.0]), GEOMETRY, BEAM, air=phantom.materials[0])
    dose = mean_glandular_dose(run, phantom, index=2, incident_kerma_mgy_per_mas=K)
    photons = 4e5 * 600**2 * GEOMETRY.solid_angle()
    mass_kg = 4 * 8 * 8 * 4.0**3 * 1.04e-6
    gray = run.materials.value[2] * photons * 1.602176634e-16 / mass_kg
    assert dose.mgy_per_mas == pytest.approx(1e3 * gray, rel=1e-12)
    assert dose.relative_error == pytest.approx(run.materials.error[2] / run.materials.value[2])
    assert 0.05 < dose.mgy_per_mgy < 1  # a part of the incident energy, at the middle of 40 mm
    assert "Monte Carlo" in dose.protocol


def test_kerma_falls_with_the_square_of_distance_and_in_air():
    air = material("air")
    near, far = (air_kerma_at(np.array([0, 0, z]), GEOMETRY, BEAM, air=air) for z in (300.0, 0.0))
    assert near > 4 * far
    assert BEAM.kerma_mgy_per_mas > far
    with pytest.raises(XrayError, match="not between"):
        air_kerma_at(np.array([0, 0, 700.0]), GEOMETRY, BEAM, air=air)


def test_dose_without_gland_is_rejected():
    run = transport(block(), GEOMETRY, BEAM, accuracy=ROUGH, seed=1)
    with pytest.raises(XrayError, match="no glandular dose"):
        mean_glandular_dose(run, block(), index=5, incident_kerma_mgy_per_mas=1.0)


def test_a_cover_holds_everything_once_and_separates_distant_parts():
    occupied = np.zeros((20, 30, 40), bool)
    occupied[2:5, 3:10, 1:39] = True
    occupied[5:18, 20:28, 30:35] = True
    boxes = bounding_boxes(occupied)
    count = np.zeros(occupied.shape, int)
    for box in boxes:
        count[tuple(slice(*span) for span in box)] += 1
    assert count.max() == 1
    np.testing.assert_array_equal(count > 0, occupied)


def test_the_cover_of_one_voxel_is_that_voxel():
    occupied = np.zeros((3, 3, 3), bool)
    occupied[1, 2, 0] = True
    assert bounding_boxes(occupied).tolist() == [[[1, 2], [2, 3], [0, 1]]]
