"""Systems: the source's arc, the detector's turn, and what leaves the field."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.phantom import Phantom
from mammosim.xray.systems import system_named, systems, tomosynthesis_geometries

NIPPLE = np.array([0.0, -60.0, 25.0])


def breast(width: float = 80.0) -> Phantom:
    """50 mm thick, 60 mm deep, on the support at z = 0; chest wall at y = 0."""
    grid = grid_around(np.array([-width / 2, -60.0, 0.0]), np.array([width / 2, 0.0, 50.0]), 5.0)
    return Phantom(grid, np.ones(grid.shape, np.uint8), (material("air"), material("adipose")))


@pytest.mark.parametrize("name", systems())
def test_the_source_stays_on_its_arc_above_the_chest_edge(name):
    of = system_named(name)
    views = tomosynthesis_geometries(breast(), of, chest_wall_y_mm=0.0, pixel_mm=1.0, nipple=NIPPLE)
    pivot = np.array([0, 0, -of.support_to_detector_mm + of.source_to_detector_mm - of.source_to_pivot_mm])
    sources = np.array([view.source for view in views])
    assert len(views) == of.views
    np.testing.assert_allclose(np.linalg.norm(sources - pivot, axis=1), of.source_to_pivot_mm, rtol=1e-12)
    seen = np.degrees(np.arctan2(sources[:, 0], sources[:, 2] - pivot[2]))
    assert np.ptp(seen) == pytest.approx(of.arc_deg, abs=1e-9)
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


def test_what_leaves_the_field_is_named_with_its_view():
    small = replace(system_named("siemens"), width_pixels=round(100 / 0.085))
    with pytest.raises(XrayError, match=r"breast in view 1 of 25 at -25.0 degrees"):
        tomosynthesis_geometries(breast(), small, chest_wall_y_mm=0.0, pixel_mm=1.0, nipple=NIPPLE)
    shallow = replace(system_named("siemens"), depth_pixels=round(50 / 0.085))
    with pytest.raises(XrayError, match="nipple in view 1"):
        tomosynthesis_geometries(breast(), shallow, chest_wall_y_mm=0.0, pixel_mm=1.0, nipple=NIPPLE)


def test_impossible_systems_are_refused():
    with pytest.raises(XrayError, match="choose one of: hologic"):
        system_named("kodak")
    with pytest.raises(XrayError, match="one view has no arc"):
        replace(system_named("ge"), views=1)
    with pytest.raises(XrayError, match="behind the detector"):
        replace(system_named("ge"), source_to_pivot_mm=700.0)
    with pytest.raises(XrayError, match="the detector turns"):
        replace(system_named("ge"), detector_turn_deg=30.0)


def test_magnification_is_the_ratio_of_distances():
    assert system_named("victre_2d").magnification(325.0) == pytest.approx(2.0)
