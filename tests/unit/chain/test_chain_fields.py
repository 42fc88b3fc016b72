"""What is drawn of a loaded body: displacement, strain, stress and J, by names with units."""

import numpy as np

from mammosim.chain.fields import fields_of
from mammosim.chain.unloaded import LoadedShape, load_loaded, save_loaded
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.io.meshes import read_cell_data, read_point_data
from mammosim.mechanics.effects import bulk_tissue

TISSUE = Tissue(3.0, 0.3, 1.0)
F = np.array([[1.1, 0.2, 0.0], [0.0, 0.9, 0.0], [0.0, 0.1, 1.0]])


def test_a_homogeneous_deformation_is_drawn_as_it_is(block, tmp_path):
    mesh = block(2)
    x = mesh.points @ F.T
    fields = fields_of(mesh, (bulk_tissue(mesh, {Label.ADIPOSE: TISSUE}),), x)
    path = tmp_path / "loaded.vtu"
    save_loaded(LoadedShape(mesh.moved_to(x), fields), {"shape": str(path)}, {})
    np.testing.assert_array_equal(load_loaded({"shape": str(path)}).mesh.points, x)

    def of_all(name):
        """One row for all cells: they deform alike."""
        values = read_cell_data(path, name)
        np.testing.assert_allclose(values, np.broadcast_to(values[0], values.shape), atol=1e-5)
        return values[0]

    np.testing.assert_allclose(read_point_data(path, "displacement_mm"), x - mesh.points, atol=1e-5)
    assert np.isclose(of_all("J"), np.linalg.det(F))
    E = (F.T @ F - np.eye(3)) / 2
    in_order = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]  # of VTK
    np.testing.assert_allclose(of_all("green_lagrange_strain"), [E[ij] for ij in in_order], atol=1e-6)
    J, b = np.linalg.det(F), F @ F.T
    sigma = TISSUE.shear_modulus_kpa * J ** (-5 / 3) * (b - np.trace(b) / 3 * np.eye(3))
    sigma += TISSUE.bulk_modulus_kpa * (J - 1) * np.eye(3)
    np.testing.assert_allclose(of_all("cauchy_stress_kpa"), [sigma[ij] for ij in in_order], atol=1e-5)
    s = sigma - np.trace(sigma) / 3 * np.eye(3)
    assert np.isclose(of_all("von_mises_kpa"), np.sqrt(1.5 * np.sum(s**2)))
