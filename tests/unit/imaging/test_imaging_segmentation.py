"""Tissues are found from a few strokes, in an order and form that the mechanics can use."""

import numpy as np
import pandas as pd
import pytest
from scipy import ndimage

from mammosim.core.errors import ConfigurationError, SegmentationError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.volume import Image
from mammosim.imaging.features import NAMES, correct_bias, features
from mammosim.imaging.overlap import dice
from mammosim.imaging.segmentation import TISSUES, Segmentation, Settings, _covered, segment

SETTINGS = Settings(trees=20)


@pytest.fixture(scope="module")
def found(chest) -> Segmentation:
    """The chest, segmented from 60 points in each tissue."""
    return segment(chest.image, chest.strokes(), settings=SETTINGS)


def test_each_tissue_overlaps_with_the_truth(chest, found) -> None:
    values = dice(found.labels, chest.labels).set_index("tissue")["dice"]
    # A layer of thickness t whose two faces are a quarter of a voxel h off overlaps by about 1 - h / (4 t):
    # 0.94 of the 17 mm and more that move, 0.88 of 8 mm of muscle, 0.67 of 3 mm of skin.
    assert values["air"] > 0.99
    assert values["thorax"] > 0.95
    assert values["deformable"] > 0.93
    assert values["glandular"] > 0.9
    assert values["muscle"] > 0.75
    assert values["skin"] > 0.5


def test_the_tissue_that_moves_is_one_piece_without_cavities(found) -> None:
    moves = np.isin(found.labels.values, DEFORMABLE)
    assert ndimage.label(moves)[1] == 1
    assert ndimage.label(found.labels.values == Label.AIR)[1] == 1
    assert ndimage.label(found.labels.values == Label.THORAX)[1] == 1


def test_skin_closes_the_body(found) -> None:
    values = found.labels.values
    beside_air = ndimage.binary_dilation(values == Label.AIR) & (values != Label.AIR)
    front = beside_air[:, :25]  # behind, muscle and thorax reach the image's border
    assert np.all(values[:, :25][front] == Label.SKIN)


def test_a_body_has_skin_before_fat_where_the_classifier_sees_some() -> None:
    """A cube of fat: on one face it has its skin, before a second one skin is likely, before a third not."""
    p = {label: np.zeros((9, 9, 9), np.float32) for label in TISSUES}
    body = np.zeros((9, 9, 9), bool)
    body[2:7, 2:7, 2:7] = True
    p[Label.ADIPOSE][body] = 1.0
    p[Label.ADIPOSE][:, :, 2], p[Label.SKIN][:, :, 2] = 0.2, 0.8
    p[Label.SKIN][:, :, 1] = 0.4
    p[Label.SKIN][:, 7, :] = 0.4
    found = _covered(body, p, np.ones(body.shape, bool)) & ~body
    assert found[2:7, 7, 3:7].all()
    assert not found[:, :, 1].any()
    assert not found[7].any()


def test_muscle_parts_breast_from_thorax(found) -> None:
    values = found.labels.values
    beside_thorax = ndimage.binary_dilation(values == Label.THORAX) & np.isin(values, DEFORMABLE)
    assert np.mean(values[beside_thorax] == Label.MUSCLE) > 0.95
    assert ndimage.label(values == Label.MUSCLE)[1] == 1


def test_markers_are_no_tissue(chest, found) -> None:
    at = np.round(chest.labels.grid.indices(np.vstack([chest.chest, chest.breast]))).astype(int)
    assert np.all(found.labels.values[tuple(at.T)] == Label.AIR)


def test_the_probability_of_gland_is_high_in_gland(chest, found) -> None:
    p, truth = found.probability.values, chest.labels.values
    assert p.min() >= 0
    assert p.max() <= 1
    assert np.median(p[truth == Label.GLANDULAR]) > 0.8
    assert np.median(p[truth == Label.ADIPOSE]) < 0.2


def test_the_same_strokes_give_the_same_labels(chest, found) -> None:
    again = segment(chest.image, chest.strokes(), settings=SETTINGS)
    np.testing.assert_array_equal(again.labels.values, found.labels.values)
    np.testing.assert_array_equal(again.probability.values, found.probability.values)


def test_an_image_changed_by_a_billionth_gives_the_same_labels(chest, found) -> None:
    """As another machine may change it: by 1e-9 of its largest value, in single precision."""
    I = chest.image.values.astype(float)
    away = np.random.default_rng(3).uniform(-1e-9, 1e-9, I.shape) * np.abs(I).max()
    other = Image(chest.image.grid, (I + away).astype(np.float32))
    assert (other.values != chest.image.values).any()
    labels = segment(other, chest.strokes(), settings=SETTINGS).labels.values
    np.testing.assert_array_equal(labels, found.labels.values)


def test_gradient_boosting_serves_as_well(chest) -> None:
    settings = Settings(classifier="gradient_boosting", trees=5)
    values = dice(segment(chest.image, chest.strokes(), settings=settings).labels, chest.labels)
    assert values.set_index("tissue")["dice"]["deformable"] > 0.9


def _without_gland(strokes: pd.DataFrame) -> pd.DataFrame:
    return strokes[strokes["tissue"] != "glandular"]


def _misspelt(strokes: pd.DataFrame) -> pd.DataFrame:
    return strokes.replace("glandular", "gland")


def _shifted(strokes: pd.DataFrame) -> pd.DataFrame:
    return strokes.assign(x_mm=strokes["x_mm"] + 500)


def _nameless(strokes: pd.DataFrame) -> pd.DataFrame:
    return strokes.drop(columns="tissue")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_without_gland, "fewer than 3 points of glandular; paint some"),
        (_misspelt, r"unknown tissue \['gland'\] in .*strokes; choose .*of: air, adipose, glandular"),
        (_shifted, "stroke points lie outside the image"),
        (_nameless, r"lack \['tissue'\]; give columns x_mm"),
    ],
)
def test_strokes_that_cannot_describe_the_image_are_rejected(chest, change, message) -> None:
    with pytest.raises(SegmentationError, match=message):
        segment(chest.image, change(chest.strokes()), settings=SETTINGS)


def test_impossible_settings_are_rejected() -> None:
    with pytest.raises(ConfigurationError, match="unknown classifier 'forest'; choose one of: random_forest"):
        Settings(classifier="forest")
    with pytest.raises(ConfigurationError, match="was it given in cm"):
        Settings(neighbourhood_mm=40.0)
    with pytest.raises(ConfigurationError, match="voxel_mm = 0 must be in"):
        Settings(voxel_mm=0.0)


def test_the_bias_field_is_removed(chest) -> None:
    x = chest.image.grid.centres()[:, 0].reshape(chest.image.grid.shape)
    biased = Image(chest.image.grid, (chest.image.values * np.exp(0.3 * np.sin(x / 90))).astype(np.float32))
    fat = ndimage.binary_erosion(chest.labels.values == Label.ADIPOSE)

    def variation(values: np.ndarray) -> float:
        return float(np.std(values[fat]) / np.mean(values[fat]))

    assert variation(correct_bias(biased).values) < 0.5 * variation(biased.values)


def test_features_have_their_names_and_units(chest) -> None:
    X = features(chest.image, neighbourhood_mm=4.0)
    assert X.shape == (*chest.image.grid.shape, len(NAMES))
    depth = X[..., NAMES.index("depth_mm")]
    assert depth[chest.labels.values == Label.AIR].max() <= 4.0 + 1e-6
    assert depth[chest.labels.values == Label.THORAX].min() > 8.0
