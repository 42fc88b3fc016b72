"""The stress of cells from the forces on their nodes is that of the law."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.effects import bulk_tissue
from mammosim.mechanics.reference import cell_strain
from mammosim.mechanics.stress import bulk_of, cauchy_stress, von_mises

F = np.array([[1.2, 0.1, 0.0], [0.05, 0.9, -0.1], [0.0, 0.2, 1.05]])
AWAY = np.array([300.0, -200.0, 100.0])


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.495])
def test_a_homogeneous_deformation_has_the_stress_of_the_law_everywhere(poisson_ratio):
    tissue = Tissue(2.0, poisson_ratio, 1.0)
    mesh = box((2, 2, 2), (10.0, 12.0, 9.0))
    x = mesh.points @ F.T + AWAY
    strain = cell_strain(mesh, x)
    sigma = cauchy_stress(bulk_tissue(mesh, {Label.ADIPOSE: tissue}), x, strain.J * strain.volume)
    # sigma = mu J^(-5/3) dev(F F^T) + k (J - 1), by hand from W
    J, b = np.linalg.det(F), F @ F.T
    dev = b - np.trace(b) / 3 * np.eye(3)
    law = tissue.shear_modulus_kpa * J ** (-5 / 3) * dev + tissue.bulk_modulus_kpa * (J - 1) * np.eye(3)
    np.testing.assert_allclose(sigma, np.broadcast_to(law, sigma.shape), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        von_mises(sigma), np.sqrt(1.5 * np.sum((law - np.trace(law) / 3 * np.eye(3)) ** 2))
    )


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.495])
def test_the_forces_of_the_cells_are_what_the_gradient_adds_up(poisson_ratio):
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    bulk = bulk_tissue(mesh, {Label.ADIPOSE: Tissue(1.0, poisson_ratio, 1.0)})
    x = mesh.points + 0.02 * mesh.points[:, [1, 2, 0]] ** 2
    forces, g = bulk.cell_forces(x), np.zeros_like(x)
    bulk.add_gradient(x, g)
    added = np.zeros_like(x)
    np.add.at(added, mesh.cells, forces)
    np.testing.assert_allclose(added, g, atol=1e-12)
    np.testing.assert_allclose(forces.sum(axis=1), 0, atol=1e-10)  # no cell pushes itself


def test_pure_pressure_has_no_von_mises_stress_and_a_pull_its_own():
    pressure, pull = -3.0 * np.eye(3), np.diag([5.0, 0.0, 0.0])
    np.testing.assert_allclose(von_mises(np.array([pressure, pull])), [0.0, 5.0], atol=1e-12)


def test_without_bulk_tissue_there_is_no_stress():
    with pytest.raises(MechanicsError, match="no bulk tissue among the effects"):
        bulk_of(())
