"""Attenuation, spectra and images against tables and closed forms of others."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import linear_attenuation, material
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import path_lengths
from mammosim.xray.tube import Tube, tube_spectrum

DATA = Path(__file__).parent / "data"
SPECTRA = pd.read_csv(DATA / "xray_half_value_layers.csv", comment="#")


@pytest.mark.parametrize("name", ["adipose", "glandular", "skin", "pmma", "water", "aluminium"])
def test_mass_attenuation_is_that_of_nist(name):
    """Within 0.5 percent at the energies of NIST's own grid, where no interpolation enters."""
    rows = pd.read_csv(DATA / "xray_mass_attenuation_nist.csv", comment="#").query("material == @name")
    found = material(name)
    mu = linear_attenuation(found, rows["energy_kev"].to_numpy()) * 10 / found.density_g_cm3
    np.testing.assert_allclose(mu, rows["mu_over_rho_cm2_g"], rtol=5e-3)


@pytest.mark.parametrize(
    "row", list(SPECTRA.query("kvp == 28").itertuples()), ids=lambda row: f"{row.anode}{row.filter}"
)
def test_half_value_layers_and_kerma_are_those_of_the_spectral_model(row):
    """Within 1.5 percent: bins of 0.5 instead of 0.1 keV, and other tables of aluminium and air."""
    tube = Tube(anode_angle_deg=row.anode_deg, window_mm_be=row.be_mm)
    beam = tube_spectrum(row.anode, row.filter, row.filter_mm, row.kvp, distance_mm=600.0, tube=tube)
    assert beam.hvl_mm_al == pytest.approx(row.hvl_mm_al, rel=0.015)
    assert beam.kerma_mgy_per_mas == pytest.approx(row.kerma_ugy_per_mas_600mm / 1e3, rel=0.015)
    assert beam.mean_energy_kev == pytest.approx(row.mean_kev, rel=0.01)
    assert beam.through(material("pmma"), 2.0).hvl_mm_al == pytest.approx(row.hvl_2mm_pmma_mm_al, rel=0.015)


def test_lengths_in_a_voxel_sphere_converge_to_the_chord_in_first_order():
    """A voxel's face misplaces the surface by about h, so halving h halves the root mean square error."""
    x, y, _ = np.eye(3)
    detector = Detector(np.array([-30.0, -30.0, -40.0]), x, y, (61, 61), 1.0)
    geometry = Geometry(np.array([3.0, 5.0, 600.0]), detector)
    R, errors = 20.0, []
    for h in (2.0, 1.0, 0.5):
        grid = grid_around(np.full(3, -22.0), np.full(3, 22.0), h)
        inside = np.sum(grid.centres() ** 2, axis=1) < R**2
        phantom = Phantom(
            grid, inside.reshape(grid.shape).astype(np.uint8), (material("air"), material("water"))
        )
        L = path_lengths(phantom, geometry)[..., 1]
        errors.append(np.sqrt(np.mean((L - chords(geometry, R)) ** 2)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(rates > 0.7), rates


def chords(geometry: Geometry, R: float) -> np.ndarray:
    """Chords (nv, nu) of the rays to the pixel centres in a sphere of radius R about 0."""
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    ray = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v) - geometry.source
    e = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    closest2 = geometry.source @ geometry.source - (e @ geometry.source) ** 2
    return 2 * np.sqrt(np.maximum(R**2 - closest2, 0))


def test_lengths_in_a_voxel_cylinder_converge_to_the_chord_in_first_order():
    """An upright half cylinder, the breast of AAPM report 195, seen from above its chest wall."""
    x, y, _ = np.eye(3)
    geometry = Geometry(
        np.array([0.0, 0.0, 600.0]), Detector(np.array([-29.5, -29.5, -5.0]), x, y, (60, 60), 1.0)
    )
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    ray = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v) - geometry.source
    # x(t) = t r from the source above the axis: inside where t |r_xy| < R and 10 < z < 40
    R, low, high = 25.0, 10.0, 40.0
    t_in, t_out = (600.0 - high) / 605.0, (600.0 - low) / 605.0
    leaves = R / np.maximum(np.hypot(ray[..., 0], ray[..., 1]), 1e-9)
    chord = np.clip(np.minimum(t_out, leaves) - t_in, 0, None) * np.linalg.norm(ray, axis=-1)
    errors = []
    for h in (2.0, 1.0, 0.5):
        grid = grid_around(np.array([-30.0, -30, low]), np.array([30.0, 30, high]), h)
        inside = np.sum(grid.centres()[:, :2] ** 2, axis=1) < R**2
        index = inside.reshape(grid.shape).astype(np.uint8)
        L = path_lengths(Phantom(grid, index, (material("air"), material("water"))), geometry)[..., 1]
        errors.append(np.mean(np.abs(L - chord)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(rates > 0.7), rates
