"""Strain of a homogeneous deformation is that deformation's."""

import numpy as np
import pytest
from mechanics_bodies import box, sphere_part

from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.tissues import Tissue
from mammosim.mechanics.effects import bulk_tissue
from mammosim.mechanics.reference import cell_quadrature, cell_strain, face_quadrature


def test_principal_strains_of_a_stretch_do_not_see_its_rotation():
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    F = rotation(np.array([20.0, 50.0, -80.0])) @ np.diag([0.8, 1.0, 1.5])
    strain = cell_strain(mesh, mesh.points @ F.T)
    assert np.allclose(strain.F, F, atol=1e-12)
    assert np.allclose(strain.J, 1.2, atol=1e-12)
    assert np.allclose(strain.principal, (np.array([0.8, 1.0, 1.5]) ** 2 - 1) / 2, atol=1e-12)


def test_the_mean_volume_ratio_is_the_ratio_of_the_cells_volumes():
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    x = mesh.points + 0.02 * mesh.points[:, [1, 2, 0]] ** 2
    ratio = cell_quadrature(x, mesh.cells).volumes.sum(axis=1) / cell_quadrature(
        mesh.points, mesh.cells
    ).volumes.sum(axis=1)
    assert pytest.approx(ratio, rel=1e-12) == cell_strain(mesh, x).J


def test_curved_cells_measure_the_hemisphere():
    mesh = sphere_part(60.0, 20.0)
    volume = cell_quadrature(mesh.points, mesh.cells).volumes.sum()
    area = face_quadrature(mesh.points, mesh.boundaries["skin"]).areas.sum()
    # Quadratic faces leave an error of (h / R)^4, about 1 %; straight ones would leave (h / R)^2, 4 %.
    assert volume == pytest.approx(2 / 3 * np.pi * 60.0**3, rel=2e-3)
    assert area == pytest.approx(2 * np.pi * 60.0**2, rel=2e-3)


def test_the_logarithmic_strain_of_a_stretch_is_its_logarithm():
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    stretch = np.array([0.8, 1.0, 1.5])
    F = rotation(np.array([20.0, 50.0, -80.0])) @ np.diag(stretch)
    assert np.allclose(cell_strain(mesh, mesh.points @ F.T).logarithmic, np.log(stretch), atol=1e-12)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.495])
def test_the_energies_of_the_cells_add_up_to_the_energy_of_the_effect(poisson_ratio):
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    bulk = bulk_tissue(mesh, {Label.ADIPOSE: Tissue(1.0, poisson_ratio, 1.0)})
    x = mesh.points + 0.02 * mesh.points[:, [1, 2, 0]] ** 2
    assert bulk.energies(x).shape == (len(mesh.cells),)
    assert bulk.energies(x).sum() == pytest.approx(bulk.energy(x), rel=1e-12)
