"""A thickness that nobody gave is a share of how deep the breast hangs, and said."""

from types import SimpleNamespace

import numpy as np
import pytest
from small_breast import small_chain
from tiny_woman import tiny_labels

from mammosim.chain.stress_free import StressFree
from mammosim.chain.thickness import GIVEN, StandardThickness, chosen_thickness, depth_in
from mammosim.core.errors import MechanicsError, MeshError
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body

NIPPLE = np.array([15.0, -30.0, 15.0])  # 60 mm before the held face, y = 30, of a cube


def test_half_of_a_depth_of_60_mm_is_30_mm_and_the_depth_is_said(block):
    found = chosen_thickness(block(), NIPPLE, share=0.5, smallest_mm=20.0)
    assert found == StandardThickness(30.0, "chosen: 0.5 of the 60 mm from the ribs to the nipple, prone")
    more = chosen_thickness(block(), NIPPLE, share=0.75, smallest_mm=20.0)
    assert more.mm == pytest.approx(45.0)


def test_one_held_node_in_front_of_the_others_does_not_make_the_breast_less_deep(block):
    mesh = block(4)
    x = mesh.points.copy()
    x[mesh.boundary_nodes("posterior")[0], 1] -= 25.0
    found = chosen_thickness(mesh.moved_to(x), NIPPLE, share=0.5, smallest_mm=20.0)
    assert found.mm == pytest.approx(30.0)


def test_labels_are_as_deep_as_from_the_nipple_to_the_first_voxel_of_the_ribs():
    labels = tiny_labels()
    depth = depth_in(labels, np.array([70.0, -57.5, 0.0]))
    assert depth == pytest.approx(57.5 + 17.5), "the first voxel of the ribs has its centre at 17.5 mm"
    assert np.isnan(depth_in(labels, np.array([400.0, -57.5, 0.0])))


def test_one_rib_in_front_of_the_others_does_not_make_labels_less_deep():
    labels = tiny_labels()
    (k, j, i) = np.rint(labels.grid.indices(np.array([[70.0, 2.5, 0.0]]))[0]).astype(int)
    labels.values[k, j, i] = Label.THORAX
    assert depth_in(labels, np.array([70.0, -57.5, 0.0])) == pytest.approx(57.5 + 17.5)


@pytest.mark.parametrize(("share", "depth"), [(0.3, 60.0), (0.9, 140.0)])
def test_a_choice_that_no_paddle_makes_is_rejected_with_the_key_to_state(block, share, depth):
    nipple = np.array([15.0, 30.0 - depth, 15.0])
    with pytest.raises(
        MechanicsError, match=rf"is {share * depth:.0f} mm, outside \[20, 120\]; .*thickness_mm"
    ):
        chosen_thickness(block(), nipple, share=share, smallest_mm=20.0)


def test_a_nipple_with_no_rib_behind_it_has_no_depth(block):
    with pytest.raises(MeshError, match="no chest wall within 30 mm"):
        chosen_thickness(block(), NIPPLE + [200, 0, 0], share=0.5, smallest_mm=20.0)


def test_the_plates_press_to_what_is_given_else_to_what_is_chosen(block, repository):
    """The depth is of the shape as measured, not of the stress-free one, which is half as deep here."""
    mesh = block(2)
    longer = mesh.moved_to(mesh.points * [1.0, 2.0, 1.0])
    given = {
        **{"mesh": longer, "stress_free": StressFree(mesh)},
        "breast": SimpleNamespace(nipple=np.array([15.0, 0.0, 15.0]), to_reference=IDENTITY),
        "pressed_body": Body({Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}),
    }
    chain = small_chain(repository)
    stated = chain.given(given)["press_setup"]
    assert (stated.thickness_mm, stated.thickness_from) == (50.0, GIVEN)
    chosen = chain.with_settings({"load.thickness_mm": None}).given(given)["press_setup"]
    assert chosen.thickness_mm == pytest.approx(30.0)
    assert chosen.thickness_from == "chosen: 0.5 of the 60 mm from the ribs to the nipple, prone"
