"""Figures of the X-ray chain show every beam, and every slice, that they are given."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.volume import Image, grid_around
from mammosim.figures.dose import dose_routes, report195, spectra
from mammosim.figures.radiograph import tomosynthesis


def test_every_beam_has_its_line_and_its_half_value_layer():
    names = ["W/Rh", "Mo/Mo", "W/Al"]
    table = pd.DataFrame(
        [{"beam": n, "energy_kev": E, "photons_per_mm2_mas": E} for n in names for E in (10.0, 20.0, 28.0)]
    )
    quality = pd.DataFrame(
        {"beam": names, "hvl_mm_al": [0.5, 0.3, 0.4], "hvl_behind_mm_al": [0.55, 0.35, 0.45]}
    )
    left, right = spectra(table, quality).axes
    assert sorted(line.get_label() for line in left.lines) == sorted(names)
    assert all(np.isclose(np.sum(line.get_ydata()), 1.0) for line in left.lines)
    assert [bar.get_width() for bar in right.patches] == [0.55, 0.35, 0.45]


@pytest.mark.parametrize(("side", "chest_wall"), [("left", 0), ("right", 1)])
def test_slices_are_hung_with_the_chest_wall_at_the_side_of_the_breast(side, chest_wall):
    grid = grid_around(np.zeros(3), np.array([40.0, 30.0, 20.0]), 2.0)
    values = np.ones(grid.shape, np.float32)
    lesion = grid.points(np.array([[5.0, 3.0, 7.0]]))[
        0
    ]  # k, j, i: y lies forward of the chest wall, at 29 mm
    values[5, 3, 7] = 9.0
    profiles = pd.DataFrame(
        {"height_mm": [-2.0, 0.0, 2.0] * 2, "difference_per_mm": [0.5, 1.0, 0.4] * 2,
         "method": ["filtered_backprojection"] * 3 + ["sart"] * 3}
    )  # fmt: skip
    slices = dict.fromkeys(("filtered_backprojection", "sart"), Image(grid, values))
    first, _, _, depth = tomosynthesis(slices, profiles, lesion, side=side).axes
    shown, (circle,) = first.images[0].get_array(), first.patches
    row, column = np.unravel_index(np.argmax(shown), shown.shape)
    # 15 voxels from front to back: the third is eleven from the chest wall
    np.testing.assert_allclose(circle.center, ((column + 0.5) * 2.0, (row + 0.5) * 2.0))
    assert column == (11, 14 - 11)[chest_wall]
    assert first.get_xlim()[0] < first.get_xlim()[1]
    said = {text.get_text(): text.get_position()[0] for text in first.texts}
    assert (said["chest wall"] > 0.5) == bool(chest_wall)
    assert (said["medial"] > 0.5) != bool(chest_wall), "the nipple points away from the chest wall"
    assert [line.get_ydata()[1] for line in depth.lines[:2]] == [1.0, 1.0]


def test_a_quantity_outside_its_gate_has_another_colour():
    rows = [("tissue", 0.5, 0.1, True), ("region 1", 2.0, -4.0, False), ("region 2", 2.0, 1.0, True)]
    table = pd.DataFrame(rows, columns=["quantity", "gate_percent", "difference_percent", "within"])
    table = table.assign(beam="16.8 keV", standard_error_ev=1.0, reference_ev=100.0)
    (ax,) = report195(table).axes
    inside, outside = (bars.lines[0] for bars in ax.containers if hasattr(bars, "lines"))
    assert list(inside.get_ydata()) == [0.1, 1.0]
    assert list(outside.get_ydata()) == [-4.0]
    assert inside.get_color() != outside.get_color()


def test_any_number_of_routes_is_drawn():
    rows = [(f"route {number}", "a protocol", 0.2 + 0.01 * number) for number in range(9)]
    one = pd.DataFrame(rows, columns=["route", "protocol", "agd_mgy_per_mgy"]).assign(standard_error=0.01)
    standard = one[1:3].assign(thickness_mm=50.0, glandularity_percent=50.0)
    left, _ = dose_routes(one.assign(volunteer="small", side="left"), standard).axes
    assert len(left.get_legend_handles_labels()[1]) == 9


def test_every_route_of_every_breast_is_drawn():
    rows = [("Monte Carlo", "this breast, Monte Carlo", 0.25), ("Monte Carlo", "standard breast", 0.3),
            ("Dance g c s", "standard breast", 0.31)]  # fmt: skip
    one = pd.DataFrame(rows, columns=["route", "protocol", "agd_mgy_per_mgy"]).assign(standard_error=0.01)
    routes = pd.concat([one.assign(volunteer=v, side="left") for v in ("small", "large")])
    standard = one[1:].assign(thickness_mm=50.0, glandularity_percent=50.0)
    left, right = dose_routes(routes, standard).axes
    assert [bars.lines[0].get_ydata().tolist() for bars in left.containers] == [
        [0.25] * 2,
        [0.3] * 2,
        [0.31] * 2,
    ]
    labels = left.get_legend_handles_labels()[1]
    assert labels == [
        "this breast, Monte Carlo",
        "standard breast, Monte Carlo",
        "standard breast, Dance g c s",
    ]
    assert len(right.containers) == 2
