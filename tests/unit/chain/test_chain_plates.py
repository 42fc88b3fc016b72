"""Plates stand in front of the chest, level with the breast; views and headlines come from plain values."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from small_breast import small_chain

from mammosim.chain.beam import spectrum_from, spectrum_table
from mammosim.chain.plates import PlateSize, craniocaudal_plates, plate_facts
from mammosim.chain.stress_free import StressFree
from mammosim.chain.thickness import GIVEN
from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body
from mammosim.study.report.headlines import headlines
from mammosim.study.report.summary import entries
from mammosim.xray.spectrum import monoenergetic

PLATE_MM = PlateSize(width=20.0, depth=40.0, height=20.0, edge_radius=5.0)


def test_plates_end_before_the_chest_and_are_level_with_the_breast(block):
    mesh = block()  # a cube of 30 mm whose face y = 30 is held
    nipple = np.array([15.0, 0.0, 12.0])
    plates = craniocaudal_plates(mesh, nipple, plate_mm=PLATE_MM, chest_gap_mm=10.0).plates
    facts = plate_facts(plates, 16.0)
    assert facts["chest_y_mm"] == pytest.approx(20.0)  # the held face less the gap
    assert (facts["support_z_mm"], facts["paddle_z_mm"]) == pytest.approx((7.0, 23.0))  # around z = 15
    assert (facts["low_x_mm"], facts["high_x_mm"]) == pytest.approx((5.0, 25.0))
    np.testing.assert_allclose(np.linalg.det(plates.axes), 1)


def test_plates_keep_clear_of_the_skin_of_the_chest_above_and_below_the_breast(block):
    """A slab 300 mm high whose skin is at y = 0 but for a breast before it: the edge is 1 mm in front."""
    mesh = block(6, 300.0)
    x = mesh.points.copy()
    near = np.abs(x[:, 2] - 150.0) < 60.0
    x[near & (x[:, 1] < 1.0), 1] -= 60.0
    placed = craniocaudal_plates(
        mesh.moved_to(x), np.array([150.0, -60.0, 150.0]), plate_mm=PLATE_MM, chest_gap_mm=10.0
    )
    assert plate_facts(placed.plates, 16.0)["chest_y_mm"] == pytest.approx(-1.0)
    assert placed.gap_mm == pytest.approx(301.0)
    assert placed.origin == "given, and 291.0 mm clear of the chest's skin"


ABOVE = np.array([60.0, 0.0, 60.0])


def held_above_and_below(block, y: float):
    """A cube of 120 mm that is held at its back, and at its top and bottom from y on."""
    mesh = block(6, 120.0)
    skin = mesh.boundaries["skin"]
    far = (mesh.points[skin][..., 1] >= y) & (np.abs(mesh.points[skin][..., 2] - 60) == 60)
    held = far.all(axis=1)
    posterior = np.vstack([mesh.boundaries["posterior"], skin[held]])
    return replace(mesh, boundaries={"skin": skin[~held], "posterior": posterior})


def closing(plates, mesh):
    """The least distance of held nodes from a plate that closes, step by step."""
    held = mesh.points[mesh.boundary_nodes("posterior")]
    first = plates.first_contact(mesh.points[mesh.boundary_nodes("skin")])
    return min(
        box.distance(held).min() for thickness in np.linspace(first, 0, 49) for box in plates.at(thickness)
    )


def test_plates_are_chosen_clear_of_skin_that_is_held_beside_the_breast_at_every_distance(block):
    """Skin is held 60 mm before the ribs, 60 mm above and below: plates 20 mm before them come upon it."""
    mesh = held_above_and_below(block, 60.0)
    deep = replace(PLATE_MM, depth=80.0)
    stated = craniocaudal_plates(mesh, ABOVE, plate_mm=deep, chest_gap_mm=20.0)
    assert closing(stated.plates, mesh) < 0
    assert (stated.gap_mm, stated.origin) == (pytest.approx(20.0), GIVEN)
    chosen = craniocaudal_plates(mesh, ABOVE, plate_mm=deep)
    assert closing(chosen.plates, mesh) == pytest.approx(1.0, abs=1e-6)
    assert chosen.gap_mm == pytest.approx(61.0)
    assert chosen.origin == "chosen: 20 mm, and 41.0 mm clear of what is held at the chest"


def test_plates_that_come_upon_no_held_skin_stand_where_they_would(block):
    """Skin that is held behind their edge moves nothing, and where none is, they stand at 20 mm."""
    behind, bare = held_above_and_below(block, 110.0), block(6, 120.0)
    for mesh in (behind, bare):
        stated = craniocaudal_plates(mesh, ABOVE, plate_mm=PLATE_MM, chest_gap_mm=20.0)
        chosen = craniocaudal_plates(mesh, ABOVE, plate_mm=PLATE_MM)
        np.testing.assert_array_equal(chosen.plates.centre, stated.plates.centre)
        assert chosen.origin == "chosen: 20 mm"


def test_between_the_plates_weight_pulls_to_the_floor_on_which_she_stands(block, repository):
    mesh = block(2)
    given = {
        **{"mesh": mesh, "stress_free": StressFree(mesh)},
        "breast": SimpleNamespace(nipple=np.array([15.0, 0.0, 15.0]), to_reference=IDENTITY),
        "pressed_body": Body({Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}),
    }
    bare = small_chain(repository, without=("weight",)).given(given)["press_setup"].effects
    heavy = small_chain(repository, also=("weight",)).given(given)["press_setup"].effects
    (weight,) = heavy[len(bare) :]
    # 27 cm3 of 1 g/cm3, a millimetre lower: 0.027 kg x 9.81 m/s2 x 1 mm in uJ; nothing forwards or aside.
    moved = [weight.energy(mesh.points + step) - weight.energy(mesh.points) for step in -np.eye(3)]
    assert moved == pytest.approx([0.0, 0.0, -0.027 * 9.81e3], rel=1e-9, abs=1e-6)


def test_plates_that_reach_no_skin_are_rejected(block):
    with pytest.raises(MeshError, match="reduce chest_gap_mm = 50"):
        craniocaudal_plates(block(), np.array([15.0, 0, 15]), plate_mm=PLATE_MM, chest_gap_mm=50.0)


def test_a_spectrum_survives_its_table():
    before = monoenergetic(20.0, fluence=3.0)
    after = spectrum_from(*spectrum_table(before))
    assert after.name == before.name
    np.testing.assert_array_equal(after.energies_kev, before.energies_kev)
    np.testing.assert_array_equal(after.fluence, before.fluence)


def test_headlines_tell_extremes_and_leave_out_what_is_absent():
    upright = pd.DataFrame(
        {
            "volunteer": ["a", "a"],
            "skin_kpa": [10.0, 0.0],
            "from_rest_mm": [30.0, 40.0],
            "outcome": ["converged", "converged"],
        }
    )
    found = headlines({"upright": upright})
    assert found["headline.skin_reduction_max_percent"] == pytest.approx(25.0)
    assert found["headline.upright_unsolved"] == 0
    assert found["headline.dose_max_mgy"] is None


def test_a_bibliography_is_read_with_its_accents():
    fields = ["author = {M{\\^i}ra, A.}", "title = {About {MRI}}", "journal = {J}", "year = {2018}"]
    text = "@article{b2,\n  " + ",\n  ".join(fields) + "\n}\n"
    assert entries(text) == [
        {"key": "b2", "author": "Mîra, A.", "year": "2018", "title": "About MRI", "in": "J"}
    ]


def test_every_number_that_the_report_quotes_is_there_though_every_table_is_missing():
    """A dash in the report, not a report that cannot be made."""
    text = (Path(__file__).parents[3] / "workflow/report/sections.yaml").read_text()
    quoted = set(re.findall(r"\{(headline\.\w+)", text))
    assert len(quoted) > 30
    assert quoted - {name for name in quoted if name.startswith("headline.dice_")} <= set(headlines({}))
