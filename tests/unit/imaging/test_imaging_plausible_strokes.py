"""Strokes that cannot have been painted in an image are found by its body and its air."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import SegmentationError
from mammosim.core.volume import Image
from mammosim.imaging.plausible_strokes import require_painted

AXES = ["x_mm", "y_mm", "z_mm"]


@pytest.fixture(scope="module")
def strokes(chest) -> pd.DataFrame:
    return chest.strokes(per_tissue=20)


def moved(strokes: pd.DataFrame, change) -> pd.DataFrame:
    points = change(strokes[AXES].to_numpy())
    return strokes.assign(**dict(zip(AXES, points.T)))


def test_strokes_in_their_tissues_pass_with_air_or_without(chest, strokes):
    require_painted(strokes, chest.image)
    require_painted(strokes[strokes.tissue != "air"], chest.image)


def test_intensities_in_any_unit_are_judged_alike(chest, strokes):
    for factor in (1e-3, 1e3):
        image = Image(chest.image.grid, (chest.image.values * factor).astype(np.float32))
        require_painted(strokes, image)


def test_dark_tissue_behind_a_dark_part_of_the_body_is_not_taken_for_air(chest, strokes):
    # Lungs, and a coil that sees nothing of the back: darker than fat by 20, and still brighter than air.
    values = chest.image.values.copy()
    values[chest.labels.values == 5] = 90.0
    require_painted(strokes, Image(chest.image.grid, values))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p: p * [-1, -1, 1], "with the signs of x and y reversed, .* can: they are RAS"),
        (lambda p: p / 1000, "which span .* mm, .* multiplied by 1000, 120 can: given in metres"),
        (lambda p: p / 10, "multiplied by 10, 120 can: given in cm"),
    ],
)
def test_one_mistake_in_all_strokes_is_named(chest, strokes, change, words):
    with pytest.raises(SegmentationError, match=words) as caught:
        require_painted(moved(strokes, change), chest.image)
    assert "\n" not in str(caught.value)


def test_strokes_at_one_place_are_no_strokes_in_any_unit(chest, strokes):
    with pytest.raises(
        SegmentationError, match=r"all 120 points lie within 6\.3 mm: were they given in metres"
    ):
        require_painted(moved(strokes, lambda p: [60, -20, 0] + p / 50), chest.image)


def test_a_point_outside_the_image_is_named_by_its_row(chest, strokes):
    far = pd.DataFrame([[0.0, 0.0, 400.0, "adipose"]], columns=[*AXES, "tissue"])
    with pytest.raises(
        SegmentationError, match=r"^row 121 \(adipose at 0\.0, 0\.0, 400\.0 mm\) lies outside"
    ):
        require_painted(pd.concat([strokes, far], ignore_index=True), chest.image)


def test_tissue_that_is_painted_in_the_air_is_named_with_its_first_row(chest, strokes):
    in_air = strokes.copy()
    in_air.loc[strokes.tissue == "adipose", AXES] = [-140.0, -80.0, 10.0]
    with pytest.raises(
        SegmentationError,
        match=r"20 of 20 points of adipose are as dark as air, .* first row 21 \(adipose at",
    ):
        require_painted(in_air, chest.image)
    in_air.loc[strokes.index[strokes.tissue == "adipose"][2:], AXES] = [60.0, -30.0, 0.0]
    require_painted(in_air, chest.image)  # a slip of the hand


def test_a_slip_of_the_hand_in_one_tissue_hides_nothing_of_another(chest, strokes):
    in_air = strokes.copy()
    for tissue, n in (("adipose", 2), ("muscle", 20)):
        in_air.loc[strokes.index[strokes.tissue == tissue][:n], AXES] = [-140.0, -80.0, 10.0]
    with pytest.raises(SegmentationError, match="20 of 20 points of muscle are as dark as air"):
        require_painted(in_air.sort_values("tissue", ignore_index=True), chest.image)


def test_too_few_points_of_a_tissue_are_named(chest, strokes):
    few = strokes[(strokes.tissue != "muscle") | (strokes.groupby("tissue").cumcount() < 2)]
    with pytest.raises(SegmentationError, match=r"^fewer than 3 points of muscle; paint some"):
        require_painted(few, chest.image)
