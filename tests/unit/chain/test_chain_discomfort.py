"""Strain, energy and pressure of known deformations, and how much lies above a mark."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mammosim.chain.discomfort import amounts_above, contact_area, skin_measures, tissue_measures
from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.tissues import Tissue
from mammosim.mechanics.effects import RigidContact, RoundedBox, bulk_tissue
from mammosim.mechanics.reference import face_quadrature

SOFT = {Label.ADIPOSE: Tissue(2.0, 0.45, 1.0), Label.GLANDULAR: Tissue(2.0, 0.45, 1.0)}
NO_FACES = pd.DataFrame({"area_mm2": [], "pressure_kpa": []})


@pytest.fixture
def cube(block):
    """A cube of 30 mm whose upper two thirds are gland."""
    mesh = block()
    mesh.tissue[mesh.points[mesh.cells[:, :4]].mean(axis=1)[:, 2] > 10.0] = Label.GLANDULAR
    return mesh


def measures(mesh, F):
    return tissue_measures(mesh, (bulk_tissue(mesh, SOFT),), mesh.points @ F.T)


def test_a_rotation_hurts_nobody(cube):
    cells = measures(cube, rotation(np.array([20.0, 50.0, -80.0])))
    assert np.abs(cells[["green_lagrange", "logarithmic", "energy_kpa"]].to_numpy()).max() < 1e-12


def test_a_stretch_is_measured_along_its_direction(cube):
    cells = measures(cube, np.diag([1.4, 1.0, 1.0]))
    assert np.allclose(cells.logarithmic, np.log(1.4), atol=1e-12)
    assert np.allclose(cells.green_lagrange, (1.4**2 - 1) / 2, atol=1e-12)


def test_shortening_in_every_direction_is_no_extension(cube):
    cells = measures(cube, 0.9 * np.eye(3))
    assert (cells.green_lagrange == 0).all()
    assert (cells.logarithmic == 0).all()
    assert (cells.principal_3 < 0).all()


def test_the_energy_of_the_cells_integrates_to_that_of_the_tissue(cube):
    F = np.array([[1.1, 0.3, 0.0], [0.0, 0.9, 0.0], [0.0, 0.2, 1.05]])
    cells = measures(cube, F)
    bulk = bulk_tissue(cube, SOFT)
    assert (cells.energy_kpa * cells.volume_mm3).sum() == pytest.approx(bulk.energy(cube.points @ F.T))


def test_everything_lies_above_nothing_and_less_above_more(cube):
    x = cube.points + 0.004 * cube.points[:, [1, 2, 0]] ** 2
    cells = tissue_measures(cube, (bulk_tissue(cube, SOFT),), x)
    table = amounts_above(cells, NO_FACES, {"logarithmic": [0.0, 0.05, 0.1, 10.0]})
    of = {tissue: rows.amount.to_numpy() for tissue, rows in table.groupby("tissue")}
    assert of["all"][0] == pytest.approx(27.0)  # cm3
    assert 2 * of["adipose"][0] == pytest.approx(of["glandular"][0])
    assert of["all"][-1] == 0
    assert (np.diff(of["all"]) <= 0).all()
    assert of["all"][1] > of["all"][2] > 0
    np.testing.assert_allclose(of["adipose"] + of["glandular"], of["all"])


def plate(mesh, axis, side):
    """A plate 0.1 mm deep in one side of a cube of 30 mm, at 1 kPa/mm."""
    centre = np.full(3, 15.0)
    centre[axis] += side * (15.0 + 10.0 - 0.1)
    faces = mesh.boundaries["skin"]
    box = RoundedBox(centre, np.eye(3), np.where(np.arange(3) == axis, 10.0, 40.0), 5.0)
    return RigidContact(faces, face_quadrature(mesh.points, faces).areas, box, penalty=1.0)


def test_the_pressures_of_the_faces_add_up_to_the_force_and_the_area_is_that_of_the_side(cube):
    top = plate(cube, 2, 1)
    faces = skin_measures(cube, {"paddle": top}, cube.points)
    # 0.1 mm deep at 1 kPa/mm is 0.1 kPa, on 30 mm by 30 mm.
    assert (faces.paddle_kpa * faces.area_mm2).sum() == pytest.approx(90.0)
    assert faces.paddle_kpa.max() == pytest.approx(0.1)
    assert contact_area(top, cube.points) == pytest.approx(900.0)
    assert contact_area(top, cube.points - [0.0, 0.0, 0.15]) == pytest.approx(900.0)  # 0.05 mm off
    assert contact_area(top, cube.points - [0.0, 0.0, 0.25]) == 0.0


def test_the_larger_pressure_of_both_plates_counts(cube):
    weak, strong = plate(cube, 2, 1), replace(plate(cube, 2, -1), penalty=2.0)
    faces = skin_measures(cube, {"paddle": weak, "support": strong}, cube.points)
    table = amounts_above(pd.DataFrame(), faces, {"pressure_kpa": [0.15, 0.05, 0.0]})
    whole = 5 * 9.0  # cm2 of skin; the sixth side is held
    assert list(table.amount) == pytest.approx([9.0, 18.0, whole])
    assert set(table.unit) == {"cm2"}


def test_an_unknown_measure_is_rejected_with_those_there_are():
    with pytest.raises(MechanicsError, match=r"no measure 'pain'.*green_lagrange, logarithmic"):
        amounts_above(pd.DataFrame(), NO_FACES, {"pain": [1.0]})


def test_effects_without_tissue_are_rejected(cube):
    with pytest.raises(MechanicsError, match="no bulk tissue"):
        tissue_measures(cube, (), cube.points)
