"""Tissues are found without a person, whatever the sequence, the unit of intensities, and the coil."""

import numpy as np
import pytest

from mammosim.core.errors import SegmentationError
from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.chest_wall import thorax_axis
from mammosim.imaging.depth_field import depth_field
from mammosim.imaging.fat_level import fat_level
from mammosim.imaging.overlap import dice
from mammosim.imaging.segmentation import Settings, segment

SETTINGS = Settings(voxel_mm=4.0)
# T1 with suppressed fat: gland, skin and muscle are brighter than fat; markers are left out.
SUPPRESSED = np.array([0.0, 250, 700, 600, 340, 0, 0])


BREAST = (Label.ADIPOSE, Label.GLANDULAR, Label.SKIN)


def _scores(image: Image, truth: LabelMap) -> dict[str, float]:
    """Dice of each tissue, and of all before the muscle."""
    labels = segment(image, settings=SETTINGS).labels
    found = dice(labels, truth).set_index("tissue")["dice"].to_dict()
    mine, true = (np.isin(each.values, BREAST) for each in (labels, truth))
    return found | {"breast": 2 * np.count_nonzero(mine & true) / (mine.sum() + true.sum())}


def test_each_tissue_overlaps_with_the_truth_without_strokes(chest) -> None:
    found = _scores(chest.image, chest.labels)
    # A layer of thickness t whose two faces are h / 4 = 1 mm off overlaps by 1 - h / (4 t), as with strokes:
    # 0.94 of 17 mm of breast. Where the muscle ends is not seen here: no dark lung is behind it.
    assert found["air"] > 0.99
    assert found["thorax"] > 0.95
    assert found["breast"] > 0.94
    assert found["glandular"] > 0.75
    assert found["skin"] > 0.5


def test_fat_may_be_darker_than_gland_and_muscle(render) -> None:
    """Body and gland; 6 mm of dark fat in 4 mm voxels do not show the front of the muscle."""
    scan = render(4.0, brightness=SUPPRESSED, noise=10.0)
    lungs = np.where(scan.labels.values == Label.THORAX, 0.25, 1.0)
    found = _scores(Image(scan.image.grid, (scan.image.values * lungs).astype(np.float32)), scan.labels)
    assert found["air"] > 0.99
    assert found["glandular"] > 0.75


def test_the_unit_of_the_intensities_does_not_matter(chest) -> None:
    given = segment(chest.image, settings=SETTINGS).labels.values
    scaled = Image(chest.image.grid, (chest.image.values * 1e-3).astype(np.float32))
    np.testing.assert_array_equal(segment(scaled, settings=SETTINGS).labels.values, given)


def test_behind_the_breast_there_is_muscle_or_thorax_where_the_coil_does_not_reach(chest) -> None:
    rows = np.arange(chest.image.grid.shape[1]) * chest.image.grid.spacing[1]
    fading = np.exp(-np.maximum(rows - 40.0, 0) / 30.0)[:, None]
    faded = Image(chest.image.grid, (chest.image.values * fading).astype(np.float32))
    values = segment(faded, settings=SETTINGS).labels.values
    soft = np.isin(values, (Label.ADIPOSE, Label.GLANDULAR, Label.SKIN))
    in_front = soft[:, :24].any(axis=1)  # in front of y = 0: breasts and the breastbone's fat
    in_front[:, :20] = in_front[:, -20:] = False  # beside the ribs fat reaches the image's back
    assert (values[:, -1][in_front] == Label.THORAX).all()


def test_markers_are_no_tissue_without_strokes(chest) -> None:
    values = segment(chest.image, settings=SETTINGS).labels.values
    at = np.round(chest.labels.grid.indices(np.vstack([chest.chest, chest.breast]))).astype(int)
    assert np.all(values[tuple(at.T)] == Label.AIR)


@pytest.mark.parametrize("sign", [-1, 1])
def test_the_brightness_of_fat_follows_the_coil(sign) -> None:
    """Gland of a third of the volume, brighter or darker than fat, under a field that falls to a third."""
    shape = (24, 24, 24)
    k = np.arange(24)
    depth = 3.0 * np.broadcast_to(np.minimum(k, 23 - k)[:, None, None], shape) + 1.5
    gland = np.zeros(shape, bool)
    gland[6:18, 6:18, 6:18] = np.random.default_rng(1).random((12, 12, 12)) < 0.5
    field = np.broadcast_to(np.exp(-k / 22.0)[None, :, None], shape)
    I = np.where(gland, 1 + 0.6 * sign, 1.0) * 200 * field
    inside = np.ones(shape, bool)
    found = fat_level(I.astype(np.float32), inside, inside, depth, np.full(3, 3.0))
    assert found.sign == sign
    off = (found.level / (200 * field))[4:-4, 4:-4, 4:-4]
    assert np.abs(off - 1).max() < 0.25


def test_a_surface_of_least_cost_bridges_what_shows_no_edge() -> None:
    """A wave of 3 voxels, not seen in some columns, and with a stronger edge far behind in others."""
    a, b = np.indices((30, 40))
    truth = np.round(15 + 3 * np.sin(a / 6) * np.cos(b / 8)).astype(int)
    cost = np.ones((30, 40, 30))
    cost[a, b, truth] = -1
    cost[8:16, 10:25] = 0
    cost[20:22, 30:33, 27] = -2
    assert np.abs(depth_field(cost, penalty=0.1) - truth).max() <= 1


@pytest.mark.parametrize(
    ("columns", "words"),
    [(slice(0, 0), "hardly any body"), ([0, -1], "at the image's midline")],
)
def test_an_image_without_a_chest_has_no_axis(columns, words) -> None:
    body = np.zeros((6, 40, 80), bool)
    body[:, :, columns] = True
    with pytest.raises(SegmentationError, match=words):
        thorax_axis(body, np.full(3, 3.5))
