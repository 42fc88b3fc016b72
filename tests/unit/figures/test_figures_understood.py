"""What was understood is drawn where it is, with sides, gravity, tissues and points, also in turned axes."""

import numpy as np
import pytest

from mammosim.core.labels import Label
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.figures.slices import in_axes_of, labels_in_slice
from mammosim.figures.understood import one_slice, understood

PRONE = np.array([0.0, -1.0, 0.0])


def texts(figure) -> list[list[str]]:
    return [[text.get_text() for text in ax.texts] for ax in figure.axes]


def test_every_plane_has_its_sides_and_gravity(torso):
    figure = understood(torso.image, gravity=PRONE, title="ada, prone: 6 x 6 x 6 mm")
    axial, coronal, sagittal = texts(figure)
    assert {"R", "L", "A", "P", "g"} <= set(axial)
    assert {"R", "L", "I", "S", "⊙ g"} <= set(coronal), "seen from the front, prone hangs towards the eye"
    assert {"A", "P", "I", "S", "g"} <= set(sagittal)
    assert figure.get_suptitle() == "ada, prone: 6 x 6 x 6 mm"
    assert "⊗ g" in texts(understood(torso.image, gravity=-PRONE, title=""))[1]


def test_letters_stand_where_the_axes_say(torso):
    axial = understood(torso.image, gravity=PRONE, title="").axes[0]
    (left,) = [text for text in axial.texts if text.get_text() == "L"]
    (front,) = [text for text in axial.texts if text.get_text() == "A"]
    assert axial.get_xlim()[1] > axial.get_xlim()[0], "x to the left rises to the right"
    assert left.get_position()[0] > 0.5
    assert axial.get_ylim()[0] > axial.get_ylim()[1], "posterior is below"
    assert front.get_position()[1] > 0.5


def test_slices_go_through_the_foremost_tissue_of_one_breast(torso):
    _, _, sagittal = understood(torso.image, gravity=PRONE, title="").axes
    assert "x = " in sagittal.get_title("left")
    x = float(sagittal.get_title("left").split("= ")[1].split(" ")[0])
    assert abs(x - 75) < 16, "two blocks of 8 mm from the middle of her left breast"


def test_points_and_labels_are_drawn_with_a_legend(torso):
    figure = understood(torso.image, labels=torso.labels, fiducials=torso.fiducials, gravity=PRONE, title="")
    (legend,) = figure.legends
    names = {text.get_text() for text in legend.get_texts()}
    assert {"glandular", "muscle", "nipple", "chest"} <= names
    assert {"left", "right"} <= set(texts(figure)[0])


def test_where_one_nipple_hides_the_other_that_at_the_slice_is_named(torso):
    sagittal = texts(understood(torso.image, fiducials=torso.fiducials, gravity=PRONE, title=""))[2]
    assert "left" in sagittal
    assert "right" not in sagittal


def test_a_point_is_drawn_on_the_voxel_that_it_lies_in_though_the_axes_are_turned():
    a = np.radians(8.0)
    R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
    grid = Grid((5, 6, 7), np.array([2.0, 3.0, 4.0]), np.array([-20.0, 5.0, 1.0]), R)
    voxel = np.array([[3.0, 2.0, 5.0]])
    drawn = in_axes_of(grid, grid.points(voxel))[0]
    np.testing.assert_allclose(drawn, grid.origin + voxel[0, ::-1] * grid.spacing)


def test_labels_of_another_grid_are_taken_where_they_lie():
    labels = LabelMap(Grid((4, 4, 4), np.full(3, 2.0), np.zeros(3)), np.zeros((4, 4, 4), np.uint8))
    labels.values[2, 1, 3] = Label.GLANDULAR  # at x 6, y 2, z 4
    fine = Grid((8, 8, 20), np.ones(3), np.array([-4.0, 0.0, 0.0]))
    found = labels_in_slice(labels, fine, "axial", 4.0)
    assert found.values.shape == (1, 8, 20)
    rows, columns = np.nonzero(found.values[0])
    assert set(columns - 4) <= {5, 6, 7}, "x from 5 to 7 mm"
    assert set(rows) <= {1, 2, 3}
    assert found.values[0, 2, 10] == Label.GLANDULAR
    assert found.values[0, :, :3].max() == Label.AIR, "outside of the labels"
    assert labels_in_slice(labels, fine, "axial", 7.0).values.max() == Label.AIR


@pytest.mark.parametrize("values", [np.zeros((4, 5)), np.arange(20.0).reshape(4, 5)])
def test_one_stored_slice_is_drawn_as_it_is(values):
    (ax,) = one_slice(values, title="ada, prone").axes
    np.testing.assert_array_equal(ax.images[0].get_array(), values)


def test_an_image_without_any_tissue_is_drawn_too():
    empty = Image(Grid((3, 4, 5), np.ones(3), np.zeros(3)), np.zeros((3, 4, 5), np.float32))
    assert len(understood(empty, gravity=PRONE, title="air").axes) == 3
