"""What scripts hand to figures: from which file each picture is, where it is cut, what is left out."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import MissingResult
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.figures import compression, deformation, radiograph, strategies, validation, volunteers

NIPPLES = Fiducials(
    ("nipple_right", "nipple_left"), ("nipple",) * 2, np.array([[-70.0, -50.0, 4.0], [75.0, -60.0, 5.0]])
)
PLATES = {"low_x_mm": 10.0, "high_x_mm": 50.0, "chest_y_mm": 5.0, "depth_mm": 40.0, "height_mm": 8.0,
          "support_z_mm": -20.0, "paddle_z_mm": 30.0}  # fmt: skip
GRID = Grid((2, 3, 4), np.array([0.5, 1.0, 2.0]), np.array([10.0, 20.0, 30.0]))


@pytest.fixture
def drawn(script, monkeypatch):
    """drawn(module, function, figure, files, told, job): what a function of drawn hands to its figure.

    figure: the module, and the name there, of what is drawn; None for a name that the script imports.
    Files are what stands in them: tables, meshes by name, or an error where the result is missing.
    """

    def read(found):
        if isinstance(found, MissingResult):
            raise found
        return found

    def run(module, function, figure, files, told=None, job=None):
        place, given = script(f"drawn.{module}"), {}

        def recorded(*args, **named):
            given.update(named, args=args)

        monkeypatch.setattr(figure[0] or place, figure[1], recorded)
        for name in ("read_mesh", "read_table", "read_json", "read_image", "read_labels"):
            monkeypatch.setattr(place, name, read, raising=False)
        monkeypatch.setattr(place, "read_fiducials", lambda path: NIPPLES, raising=False)
        monkeypatch.setattr(place, "read_cell_data", lambda of, name: (of, name), raising=False)
        monkeypatch.setattr(place, "read_point_data", lambda of, name: (of, name), raising=False)
        monkeypatch.setattr(place, "read_if_there", lambda found: pd.DataFrame(found), raising=False)
        getattr(place, function)(files, told or {}, job or {})
        return SimpleNamespace(**given)

    return run


def test_plates_are_drawn_outside_of_the_faces_that_hold_the_breast(drawn):
    files = {"plates": PLATES, "stress_free": "rest", "shape": "pressed",
             "faces": pd.DataFrame({"paddle_kpa": [1.0, 0.0], "support_kpa": [0.0, 2.0]})}  # fmt: skip
    given = drawn("presses", "compression", (compression, "compressed_breast"), files)
    assert given.args[:2] == ("rest", "pressed")
    paddle, support = given.args[2]
    np.testing.assert_array_equal(paddle.centre, [30.0, 5.0 - 20.0, 30.0 + 4.0])
    np.testing.assert_array_equal(support.centre, [30.0, 5.0 - 20.0, -20.0 - 4.0])
    np.testing.assert_array_equal(paddle.half_sizes, [20.0, 20.0, 4.0])
    assert given.cut_x_mm == 30.0
    assert given.strain == ("pressed", "green_lagrange")
    assert given.pressure.tolist() == [1.0, 0.0], "of the paddle"


def test_strategies_that_failed_have_no_column_of_discomfort_and_an_empty_map(drawn):
    pressure = {"pressure_kpa": [1.0, 3.0], "paddle_kpa": [1.0, 0.0]}
    files = {"faces": [pressure, {}, pressure], "shapes": ["a", "b", "c"], "plates": PLATES,
             "maps": [{"thickness_mm": [4.0]}, {}]}  # fmt: skip
    given = drawn("presses", "discomfort", (strategies, "discomfort"), files, {"strategies": ["x", "y", "z"]})
    (pressed,) = given.args
    assert {name: each.mesh for name, each in pressed.items()} == {"x": "a", "z": "c"}
    assert pressed["x"].pressure_kpa.tolist() == [1.0, 3.0]
    assert pressed["z"].energy_kpa == ("c", "energy_kpa")
    np.testing.assert_array_equal(given.centre, [30.0, 5.0, 5.0])
    (maps,) = drawn(
        "presses", "thickness", (strategies, "thickness_maps"), files, {"strategies": ["x", "y"]}
    ).args
    assert [len(maps[name]) for name in ("x", "y")] == [1, 0]


def test_without_any_map_of_thickness_the_standards_reason_is_said(drawn):
    files = {"maps": [{}, {}], "plates": MissingResult("press ada left standard: it slides away")}
    figure, told = (strategies, "thickness_maps"), {"strategies": ["x", "y"]}
    with pytest.raises(MissingResult, match="it slides away"):
        drawn("presses", "thickness", figure, files, told)
    files["maps"][1] = {"thickness_mm": [4.0]}
    assert len(drawn("presses", "thickness", figure, files, told).args[0]["y"]) == 1, "one is enough"


def test_an_image_is_shown_as_it_was_scanned_beside_how_it_was_registered(drawn):
    fixed, moving, after = (Image(GRID, np.full(GRID.shape, v, np.float32)) for v in (1.0, 2.0, 3.0))
    files = {"fixed": fixed, "moving": moving, "after": after, "fiducials": "", "steps": "steps"}
    given = drawn("volunteers", "registration", (volunteers, "registration"), files)
    assert [float(image.values.max()) for image in given.args[:3]] == [1.0, 2.0, 3.0]
    assert given.args[3] == "steps"
    assert given.at_mm == 5.0, "at the left nipple"


def test_tissues_are_shown_behind_the_nipple_and_with_scores_where_the_truth_is_known(drawn):
    files, told = {"image": "i", "labels": "l", "fiducials": "", "dice": ["scores"]}, {"behind_mm": 20.0}
    given = drawn("volunteers", "segmentation", (volunteers, "segmentation"), files, told)
    assert given.args == ("i", "l", "scores")
    np.testing.assert_array_equal(given.point, [75.0, -60.0 + 20.0, 5.0])
    given = drawn("volunteers", "segmentation", (volunteers, "segmentation"), files | {"dice": []}, told)
    assert given.args == ("i", "l", None)


def test_a_mesh_is_cut_through_the_left_nipple_and_both_are_marked(drawn):
    given = drawn("volunteers", "mesh", (None, "mesh_with_tissues"), {"mesh": "mesh", "fiducials": ""})
    assert given.cut_x_mm == 75.0
    np.testing.assert_array_equal(given.nipples, NIPPLES.points[::-1])


def test_images_of_positions_go_with_their_markers_and_their_gravity(drawn):
    told = {"gravity": {"supine": "0 2 0", "prone": "0 -1 0"}}
    files = {"images": ["s", "p"], "fiducials": ["", ""]}
    images, _, gravity = drawn("volunteers", "positions", (volunteers, "positions"), files, told).args
    assert images == {"supine": "s", "prone": "p"}
    assert {name: g.tolist() for name, g in gravity.items()} == {"supine": [0, 1, 0], "prone": [0, -1, 0]}


def test_shapes_are_named_by_their_method_and_those_that_are_missing_left_out(drawn):
    files = {"measured": "m", "shapes": ["a", MissingResult("no"), "c"], "fiducials": ""}
    told = {"methods": ["fixed_point", "inverse", "mean_start"]}
    given = drawn("shapes", "stress_free", (deformation, "stress_free"), files, told)
    assert given.args == ({"measured": "m", "fixed point": "a", "mean start": "c"},)
    assert (given.x_mm, given.z_mm) == (75.0, 5.0)


def test_a_shape_that_took_other_moduli_is_drawn_by_their_name_and_no_other_twice(drawn):
    attempts = pd.DataFrame({"method": ["anderson", "inverse"], "moduli_factor": [1.0, 2.0]})
    files = {"measured": "m", "shapes": [MissingResult("no")], "fiducials": ""}
    files |= {"used": "u", "attempts": attempts}
    told = {"methods": ["anderson"]}
    given = drawn("shapes", "stress_free", (deformation, "stress_free"), files, told)
    assert given.args == ({"measured": "m", "inverse, all moduli times 2": "u"},)
    files |= {"shapes": ["a"], "attempts": attempts[:1]}
    given = drawn("shapes", "stress_free", (deformation, "stress_free"), files, told)
    assert given.args == ({"measured": "m", "anderson": "a"},)


def test_upright_shapes_are_named_by_their_skin_and_rows_are_hers(drawn):
    measured = SimpleNamespace(moved_to=lambda points: points)
    table = pd.DataFrame({"volunteer": ["ada", "eva"], "skin_kpa": [0.0, 10.0]})
    files = {"measured": measured, "shapes": ["a", "b"], "table": table, "fiducials": ""}
    given = drawn(
        "shapes", "upright", (deformation, "upright"), files, {"skin_kpa": [0.0, 10.0]}, {"v": "eva"}
    )
    shapes, rows = given.args
    assert shapes == {
        "measured, prone": measured, "without skin": ("a", "predicted"), "skin 10 kPa": ("b", "predicted"),
    }  # fmt: skip
    assert rows.volunteer.tolist() == ["eva"]


def test_the_truth_is_moved_into_the_common_frame(drawn, script, monkeypatch):
    shapes = script("drawn.shapes")
    truth = SimpleNamespace(points=np.array([[1.0, 2.0, 3.0]]), moved_to=lambda points: points)
    monkeypatch.setattr(shapes, "read_mesh", lambda path: truth)
    monkeypatch.setattr(shapes, "read_transform", lambda path: lambda points: points + 10)
    assert shapes.true_shape("", "").tolist() == [[11.0, 12.0, 13.0]]


def pairs_of_skins(block):
    """Two measured positions, and predictions 3 mm in front of them."""
    measured = block(4, 100.0)
    return measured, measured.moved_to(measured.points - [0.0, 3.0, 0.0])


def test_distances_are_shown_of_all_positions_and_not_near_where_the_body_was_cut(drawn, block):
    measured, found = pairs_of_skins(block)
    files = {"shapes": [found, found], "measured": [measured, measured], "fiducials": ""}
    told = {"fitted": {"supine": True, "supine_tilted": False}}
    given = drawn("fits", "prediction", (validation, "prediction"), files, told, {"p": "supine_tilted"})
    shapes, skin, distances = given.args
    assert shapes == {"measured": measured, "predicted": found}
    assert list(distances) == ["supine, fitted", "supine tilted, held out"]
    assert max(distances["supine, fitted"]) == pytest.approx(3.0)
    y = measured.points[measured.boundary_nodes("skin"), 1]
    assert np.isnan(skin.distance[y > 81]).all(), "the body was cut at 100 mm"
    assert np.nanmax(skin.distance) == pytest.approx(3.0)


def test_a_position_without_a_prediction_is_left_out_but_not_her_own(drawn, block):
    measured, found = pairs_of_skins(block)
    lost = MissingResult("no equilibrium")
    files = {"shapes": [lost, found], "measured": [measured, measured], "fiducials": ""}
    told = {"fitted": {"supine": True, "supine_tilted": False}}
    figure = (validation, "prediction")
    given = drawn("fits", "prediction", figure, files, told, {"p": "supine_tilted"})
    assert list(given.args[2]) == ["supine tilted, held out"]
    with pytest.raises(MissingResult, match="no equilibrium"):
        drawn("fits", "prediction", figure, files, told, {"p": "supine"})
    unsolved = found.moved_to(np.full_like(found.points, np.nan))
    given = drawn("fits", "prediction", figure, files | {"shapes": [unsolved, found]}, told, {"p": "supine"})
    assert list(given.args[0]) == ["measured"], "nothing was predicted"
    assert np.isnan(given.args[1].distance).all()


def test_a_mammogram_is_the_first_layer_of_its_file_and_the_lesion_the_second(drawn):
    values = np.stack([np.full((3, 4), 5.0), np.eye(3, 4), np.zeros((3, 4))])
    layers = Image(Grid((3, 3, 4), np.array([0.2, 0.2, 1.0]), np.zeros(3)), values)
    files = {"image": layers, "row": pd.DataFrame({"mas": [80.0]})}
    given = drawn("xrays", "mammogram", (radiograph, "mammogram"), files, job={"side": "right"})
    np.testing.assert_array_equal(given.args[0], 5.0)
    np.testing.assert_array_equal(given.lesion, np.eye(3, 4, dtype=bool))
    assert (given.pixel_mm, given.row, given.side) == (0.2, {"mas": 80.0}, "right")


def test_slices_are_cut_where_the_lesion_is_in_the_room_of_the_breast(drawn):
    values = np.zeros(GRID.shape, np.uint8)
    values[1, 2, 2:] = Label.LESION
    files = {"phantom": LabelMap(GRID, values), "profiles": "p", "filtered_backprojection": "f", "sart": "s"}
    given = drawn("xrays", "tomosynthesis", (radiograph, "tomosynthesis"), files, job={"side": "left"})
    slices, profiles, lesion = given.args
    assert slices == {"filtered_backprojection": "f", "sart": "s"}
    assert profiles == "p"
    np.testing.assert_allclose(lesion, [10 + 2.5 * 0.5, 20 + 2 * 1.0, 30 + 1 * 2.0])
