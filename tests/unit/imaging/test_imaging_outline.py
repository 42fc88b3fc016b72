"""The body's outline does not depend on the unit of the intensities, nor on how far the coil reaches."""

import numpy as np
import pytest
from scipy import ndimage

from mammosim.core.errors import ImageError
from mammosim.core.labels import Label
from mammosim.core.volume import Image
from mammosim.imaging.markers import find_markers
from mammosim.imaging.outline import body_mask

# Fat-suppressed: fat is the darkest of the tissues, gland and skin are bright; and T1. Markers are left out.
SUPPRESSED = np.array([0.0, 150, 700, 600, 350, 250, 0])
T1 = np.array([0.0, 1000, 450, 350, 280, 250, 0])


def _dice(a: np.ndarray, b: np.ndarray) -> float:
    return float(2 * np.count_nonzero(a & b) / (np.count_nonzero(a) + np.count_nonzero(b)))


def _like(chest, values: np.ndarray) -> Image:
    return Image(chest.image.grid, values.astype(np.float32))


def _body(chest) -> np.ndarray:
    return ~np.isin(chest.labels.values, (Label.AIR, Label.MARKER))


def _noisy(values: np.ndarray, noise: float) -> np.ndarray:
    a, b = np.random.default_rng(2).normal(scale=noise, size=(2, *values.shape))
    return np.hypot(values + a, b)


@pytest.mark.parametrize(("scale", "zero"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 500.0), (1e-3, -40.0)])
def test_unit_and_zero_of_the_intensities_do_not_matter(chest, scale, zero) -> None:
    given = body_mask(chest.image)
    np.testing.assert_array_equal(body_mask(_like(chest, scale * chest.image.values + zero)), given)


def test_the_body_is_found_where_fat_is_darker_than_gland(chest) -> None:
    smooth = ndimage.gaussian_filter(SUPPRESSED[chest.labels.values], 0.4)
    found = body_mask(_like(chest, _noisy(smooth, 10.0)))
    # A body of 60 mm half depth whose surface is a quarter of a 4 mm voxel off: 1 - 1 / 60.
    assert _dice(found, _body(chest)) > 0.98


def test_where_the_coil_does_not_reach_the_body_goes_on(chest) -> None:
    """exp(-y / 30 mm) from the foremost skin on: the back of the body is as dark as the noise of the air."""
    rows = np.arange(chest.image.grid.shape[1]) * chest.image.grid.spacing[1]
    fading = np.exp(-np.maximum(rows - 40.0, 0) / 30.0)[:, None]
    found = body_mask(_like(chest, _noisy(chest.image.values * fading, 20.0)))
    middle = slice(20, -20)
    assert found[:, -1, middle].all()
    assert _dice(found[:, :20], _body(chest)[:, :20]) > 0.97


def test_a_dark_frame_of_the_image_lets_no_air_into_the_lungs(chest) -> None:
    """Scanners leave voxels at the border without signal: behind the body they are no way for the air."""
    values = chest.image.values.copy()
    values[chest.labels.values == Label.THORAX] = 5.0
    values[:, :, :1] = values[:, :, -1:] = values[:, -1:] = 0.0
    found = body_mask(_like(chest, values))
    assert found[chest.labels.values == Label.THORAX].mean() > 0.98


def test_an_image_without_anything_is_rejected(chest) -> None:
    with pytest.raises(ImageError, match="all voxels have the value 7; give an image of a body"):
        body_mask(_like(chest, np.full(chest.image.grid.shape, 7.0)))


@pytest.mark.parametrize("brightness", [SUPPRESSED, T1])
def test_no_marker_is_found_in_an_image_without_markers(render, brightness) -> None:
    """Bright skin, gland, the texture of the thorax, and a vessel under the skin are none."""
    image = render(3.0, high=(0, 30, 60), brightness=brightness).image
    bright = image.values.copy()
    bright[20:23, 20:23, 30:33] = 1500.0
    assert len(find_markers(Image(image.grid, bright))) == 0
