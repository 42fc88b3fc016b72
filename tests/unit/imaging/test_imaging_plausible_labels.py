"""Labels that were not drawn in the image beside them, or are mirrored against it, are found by their fit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tiny_woman import tiny_image, tiny_labels

from mammosim.core.errors import ImageError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap
from mammosim.imaging.plausible_labels import FAR_MM, _Compared, _Fit, require_drawn_in
from mammosim.imaging.plausible_points import Skin


def moved(labels: LabelMap, shift: list[float]) -> LabelMap:
    """The same labels at another place, mm."""
    grid = labels.grid
    return LabelMap(Grid(grid.shape, grid.spacing, grid.origin + shift, grid.direction), labels.values)


def test_labels_of_an_image_pass_also_on_finer_voxels_and_a_voxel_off():
    coarse = tiny_labels()
    for labels in (coarse, tiny_labels(4.0), moved(coarse, [5.0, 5.0, -5.0])):
        require_drawn_in(labels, tiny_image(coarse))


@pytest.mark.parametrize("shift", [[0.0, -70.0, 0.0], [0.0, 0.0, 150.0], [300.0, 0.0, 0.0]])
def test_labels_in_another_frame_are_rejected(shift):
    labels = tiny_labels()
    with pytest.raises(ImageError, match=r"\d+ % of the labelled tissue lie in the body .* at least 50 %"):
        require_drawn_in(moved(labels, shift), tiny_image(labels))


def uneven(side: float = 1.3, end: float = 20.0) -> LabelMap:
    """The tiny woman with a larger left breast that has more gland, and both nearer to her head."""
    labels = tiny_labels()
    x, y, z = np.moveaxis(labels.grid.centres().reshape(*labels.grid.shape, 3), -1, 0)
    wide = np.where(x > 0, side, 1.0)
    r = np.sqrt(((np.abs(x) - 70) / 50) ** 2 + (y / (60 * wide)) ** 2 + ((z - end) / 50) ** 2)
    values = np.where(y > 0, labels.values, np.where(r < 1, np.uint8(Label.ADIPOSE), np.uint8(Label.AIR)))
    values[(r < np.where(x > 0, 0.8, 0.4)) & (y < 0)] = Label.GLANDULAR
    return replace(labels, values=values)


def flipped(labels: LabelMap, *axes: int) -> LabelMap:
    """The array flipped under the same header."""
    return replace(labels, values=np.flip(labels.values, axes).copy())


def of_one_code(labels: LabelMap) -> LabelMap:
    """A map that knows the breast alone."""
    breast = np.isin(labels.values, (Label.ADIPOSE, Label.GLANDULAR))
    return replace(labels, values=np.where(breast, np.uint8(Label.ADIPOSE), np.uint8(Label.AIR)))


@pytest.mark.parametrize("as_given", [lambda labels: labels, of_one_code])
@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ((2,), "mirrored left to right"),
        ((0,), "mirrored head to feet"),
        ((0, 2), "mirrored left to right and head to feet"),
        ((1, 2), "mirrored left to right and front to back"),
    ],
)
def test_labels_that_are_mirrored_under_a_right_header_are_found(as_given, axes, words):
    labels = uneven()
    require_drawn_in(as_given(labels), tiny_image(labels))
    with pytest.raises(
        ImageError, match=rf"^the labels are oriented otherwise than the image: .*; {words} their"
    ) as e:
        require_drawn_in(flipped(as_given(labels), *axes), tiny_image(labels))
    assert len(str(e.value).splitlines()) == 1


@pytest.mark.parametrize("axis", [0, 2])
def test_a_body_that_looks_the_same_when_mirrored_passes_either_way(axis):
    labels = tiny_labels()
    require_drawn_in(flipped(labels, axis), tiny_image(labels))


def test_labels_of_one_breast_are_not_taken_for_those_of_the_other():
    labels = uneven()
    half = labels.values.copy()
    half[..., : half.shape[2] // 2] = Label.AIR
    for values in (half, np.where(half == Label.THORAX, np.uint8(Label.AIR), half)):
        require_drawn_in(replace(labels, values=values), tiny_image(labels))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("step", [-20.0, -10.0, 10.0, 20.0])
def test_labels_that_are_moved_against_their_image_are_found_with_how_far(axis, step):
    labels, shift = uneven(), step * np.eye(3)[axis]
    back = " ".join(f"{each:.0f}" for each in 0.0 - shift)
    with pytest.raises(
        ImageError, match=rf"^the labels lie elsewhere than .*; moved by {back} mm .* their"
    ) as e:
        require_drawn_in(moved(labels, shift), tiny_image(labels))
    assert len(str(e.value).splitlines()) == 1


def test_labels_of_a_single_tissue_that_are_moved_are_found_from_20_mm_on():
    labels = of_one_code(uneven())
    require_drawn_in(labels, tiny_image(uneven()))
    with pytest.raises(ImageError, match=r"moved by -20 0 0 mm"):
        require_drawn_in(moved(labels, [20.0, 0.0, 0.0]), tiny_image(uneven()))


def test_labels_on_a_tilted_grid_that_are_mirrored_along_it_are_found():
    """Tilted by 8 degrees about y: mirrored along x, and not along the grid, its ends would be 20 mm off."""
    labels, tilt = uneven(), Rotation.from_rotvec([0.0, np.radians(8.0), 0.0]).as_matrix()
    tilted = replace(labels, grid=replace(labels.grid, direction=tilt))
    require_drawn_in(tilted, tiny_image(tilted))
    with pytest.raises(ImageError, match=r"mirrored left to right their skin is 2\.\d mm"):
        require_drawn_in(flipped(tilted, 2), tiny_image(tilted))


def test_labels_that_lie_in_the_body_and_off_its_skin_are_rejected():
    """Half as large as the body: nowhere does their front fit its skin."""
    labels, grid = uneven(), uneven().grid
    small = Grid(grid.shape, grid.spacing / 2, grid.origin / 2 + [0.0, 20.0, 0.0], grid.direction)
    with pytest.raises(
        ImageError, match=r"^\d+ % of the front of the labelled tissue lie within .* of one posi"
    ):
        require_drawn_in(LabelMap(small, labels.values), tiny_image(labels))


def test_labels_lie_elsewhere_only_where_skin_and_brightness_fit_half_as_well_again():
    given = _Fit(d=6.0, R2=0.3)
    assert _Fit(d=3.9, R2=0.46).is_where(given)
    assert not _Fit(d=4.1, R2=0.46).is_where(given)
    assert not _Fit(d=3.9, R2=0.44).is_where(given)


def test_what_is_far_from_the_skin_counts_as_far_and_no_more():
    """A sheet before the breasts, 75 mm in front of the chest: most of it is farther off than what counts."""
    labels = uneven()
    image, values = tiny_image(labels), np.zeros_like(labels.values)
    values[:, 0] = Label.ADIPOSE
    found = _Compared.of(replace(labels, values=values), image, Skin.of(image)).fit(lambda points, _: points)
    assert found.d <= FAR_MM
