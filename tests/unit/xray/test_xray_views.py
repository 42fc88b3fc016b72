"""Views: the source's arc, the detector's turn, where the breast is placed, and what leaves the field."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.volume import grid_around
from mammosim.io.tabulated import tabulated
from mammosim.xray.attenuation import material
from mammosim.xray.phantom import Phantom
from mammosim.xray.placement import Outline, Room
from mammosim.xray.systems import system_named, system_of, systems
from mammosim.xray.views import mammography_geometry, tomosynthesis_geometries

MATERIALS = (material("air"), material("adipose"))


def breast(width: float = 80.0, *, lean: float = 0.0) -> Phantom:
    """50 mm thick, 60 mm deep, on the support at z = 0; chest wall at y = 0; `lean` mm lower at its left."""
    grid = grid_around(np.array([-width / 2, -60.0, 0.0]), np.array([width / 2, 0.0, 50.0]), 5.0)
    index = np.ones(grid.shape, np.uint8)
    x, z = grid.centres().reshape(*grid.shape, 3)[..., 0], grid.centres().reshape(*grid.shape, 3)[..., 2]
    index[(x > 0) & (z > 50.0 - lean)] = 0
    return Phantom(grid, index, MATERIALS)


def seen(phantom: Phantom, views: tuple) -> Room:
    """The room around its shadow."""
    return Room.around(Outline.of(phantom, 0.0).points, views)


@pytest.mark.parametrize("name", systems())
def test_the_source_stays_on_its_arc_above_the_chest_edge(name):
    of = system_named(name)
    views = tomosynthesis_geometries(breast(), of, chest_wall_y_mm=0.0, pixel_mm=1.0)
    pivot = np.array([0, 0, -of.support_to_detector_mm + of.source_to_detector_mm - of.source_to_pivot_mm])
    sources = np.array([view.source for view in views])
    assert len(views) == of.views
    np.testing.assert_allclose(np.linalg.norm(sources - pivot, axis=1), of.source_to_pivot_mm, rtol=1e-12)
    angles = np.degrees(np.arctan2(sources[:, 0], sources[:, 2] - pivot[2]))
    assert np.ptp(angles) == pytest.approx(of.arc_deg, abs=1e-9)
    assert np.all(sources[:, 1] == 0.0)
    middle = views[len(views) // 2]
    assert middle.source_height_mm == pytest.approx(of.source_to_detector_mm)


def test_a_still_detector_stays_and_a_turning_one_turns_with_the_tube():
    still, turning = (
        tomosynthesis_geometries(breast(), system_named(name), chest_wall_y_mm=0.0, pixel_mm=1.0)
        for name in ("siemens", "hologic")
    )
    assert all(np.array_equal(view.detector.corner, still[0].detector.corner) for view in still)
    normals = np.array([view.detector.normal for view in turning])
    turn = np.degrees(np.arccos(normals[0] @ normals[-1]))
    assert turn == pytest.approx(4.2)
    assert normals[0, 0] < 0 < normals[-1, 0]
    # the middle of the chest edge is where the detector turns about
    edges = [v.detector.corner + v.detector.size_mm[0] / 2 * v.detector.u for v in turning]
    np.testing.assert_allclose(edges, np.tile(edges[0], (15, 1)), atol=1e-9)


def test_a_point_moves_over_the_detector_by_its_height_times_the_tangent():
    """Source above the pivot on the detector: shift of a point at height h is h R sin a/(R cos a - h)."""
    flat = replace(system_named("siemens"), source_to_pivot_mm=650.0)
    views = tomosynthesis_geometries(breast(), flat, chest_wall_y_mm=0.0, pixel_mm=1.0)
    point = np.array([[0.0, -30.0, 40.0]])
    h, a = 40.0 + flat.support_to_detector_mm, np.radians(flat.angles_deg)
    u = np.array([view.project(point)[0, 0] for view in views])
    moved = h * 650 * np.sin(a) / (650 * np.cos(a) - h)
    np.testing.assert_allclose(u - u[12], moved, atol=1e-9)


@pytest.mark.parametrize("name", systems())
@pytest.mark.parametrize("lean", [0.0, 30.0])
def test_the_shadow_has_the_same_room_on_both_sides_over_all_views(name, lean):
    """Placed to 0.1 mm, and magnified by 1.2 at most: the sides differ by less than 0.2 mm."""
    leaning = breast(lean=lean)
    room = seen(
        leaning, tomosynthesis_geometries(leaning, system_named(name), chest_wall_y_mm=0.0, pixel_mm=1.0)
    )
    assert room.low_mm == pytest.approx(room.high_mm, abs=0.2)
    middle = (mammography_geometry(leaning, chest_wall_y_mm=0.0),)
    assert seen(leaning, middle).low_mm == pytest.approx(seen(leaning, middle).high_mm, abs=0.2)


def test_a_leaning_breast_stands_beside_the_middle_of_the_detector():
    """Its higher half has the longer shadow: without placement one side has less room than the other."""
    of = system_named("siemens")
    even, leaning = (
        tomosynthesis_geometries(breast(lean=lean), of, chest_wall_y_mm=0.0, pixel_mm=1.0)[12].source[0]
        for lean in (0.0, 30.0)
    )
    assert even == pytest.approx(0.0, abs=0.1)
    assert leaning < -1.0


def test_room_is_what_lies_between_shadow_and_edge():
    """From straight above, 650 mm: 80 mm at a height of 50 + 25 mm are 80 650/575 mm wide."""
    one = replace(system_named("victre_2d"), support_to_detector_mm=25.0)
    room = seen(breast(), tomosynthesis_geometries(breast(), one, chest_wall_y_mm=0.0, pixel_mm=1.0))
    width = 80 * 650 / 575
    assert room.needs_mm == pytest.approx((width, 60 * 650 / 575))
    assert room.low_mm == pytest.approx((255 - width) / 2, abs=0.1)
    # the detector of whole pixels of 1 mm is 128 mm deep
    assert room.front_mm == pytest.approx(128 - 60 * 650 / 575, abs=0.1)


def test_what_leaves_the_field_is_named_with_its_view_and_with_systems_that_hold_it():
    small = replace(system_named("siemens"), width_pixels=round(100 / 0.085))
    with pytest.raises(XrayError, match=r"siemens in view \d+ of 25 at .*\d\.\d degrees.* hologic \(\d+ mm"):
        tomosynthesis_geometries(breast(), small, chest_wall_y_mm=0.0, pixel_mm=1.0)
    shallow = replace(system_named("siemens"), depth_pixels=round(50 / 0.085))
    with pytest.raises(XrayError, match="leaves the detector of siemens in view"):
        tomosynthesis_geometries(breast(), shallow, chest_wall_y_mm=0.0, pixel_mm=1.0)
    with pytest.raises(XrayError, match="no other system holds her either"):
        tomosynthesis_geometries(breast(400.0), small, chest_wall_y_mm=0.0, pixel_mm=1.0)


def test_advice_names_only_keys_of_that_system():
    with pytest.raises(XrayError, match=r"enlarge xray\.field_mm") as mammography:
        mammography_geometry(breast(), chest_wall_y_mm=0.0, field_mm=(240.0, 80.0))
    with pytest.raises(XrayError, match=r"xray\.tomosynthesis\.system") as tomosynthesis:
        tomosynthesis_geometries(breast(200.0), system_named("victre"), chest_wall_y_mm=0.0, pixel_mm=1.0)
    assert "tomosynthesis" not in str(mammography.value)
    assert "field_mm" not in str(tomosynthesis.value)


def test_what_a_system_holds_does_not_depend_on_the_pixels_that_are_asked_for():
    """With pixels of 5 mm the detector is 115 mm deep, with its own 117 mm; the shadow needs 116 mm."""
    deep = grid_around(np.array([-40.0, -103.0, 0.0]), np.array([40.0, 0.0, 50.0]), 1.0)
    block = Phantom(deep, np.ones(deep.shape, np.uint8), MATERIALS)
    of = system_named("siemens")
    for pixel_mm in (0.5, 5.0):
        assert len(tomosynthesis_geometries(block, of, chest_wall_y_mm=0.0, pixel_mm=pixel_mm)) == 25


def test_a_gap_in_the_row_of_one_system_does_not_hide_the_reason_of_another(monkeypatch):
    table = tabulated("imaging_systems")
    gap = table.assign(views=table.views.where(table.system != "ge"))
    monkeypatch.setattr("mammosim.xray.systems.tabulated", lambda name: gap)
    assert system_named("hologic").angles_deg.shape == (15,)
    with pytest.raises(XrayError, match=r"detector of victre .* hologic \(\d+ mm to spare\), siemens"):
        tomosynthesis_geometries(breast(180.0), system_named("victre"), chest_wall_y_mm=0.0, pixel_mm=1.0)


def test_impossible_systems_are_rejected():
    with pytest.raises(XrayError, match="choose one of: hologic"):
        system_named("kodak")
    with pytest.raises(XrayError, match="one view has no arc"):
        replace(system_named("ge"), views=1)
    with pytest.raises(XrayError, match="behind the detector"):
        replace(system_named("ge"), source_to_pivot_mm=700.0)
    with pytest.raises(XrayError, match="the detector turns"):
        replace(system_named("ge"), detector_turn_deg=30.0)


@pytest.mark.parametrize("made", [lambda t: t.drop(columns="arc_deg"), lambda t: t.assign(arc_deg=np.nan)])
def test_a_system_that_lacks_something_is_rejected_by_name_with_what_it_lacks(made):
    with pytest.raises(XrayError, match=r"'ge' lacks arc_deg; complete its row .* one: hologic"):
        system_of(made(pd.DataFrame(tabulated("imaging_systems"))), "ge")


def test_every_system_of_the_table_is_complete():
    assert all(system_named(name).size_mm[0] > 200 for name in systems())


def test_magnification_is_the_ratio_of_distances():
    assert system_named("victre_2d").magnification(325.0) == pytest.approx(2.0)
