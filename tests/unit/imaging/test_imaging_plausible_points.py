"""Points that cannot have been marked in an image are found by its outline, and what went wrong is said."""

import numpy as np
import pytest

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Image
from mammosim.imaging.plausible_points import Skin, require_plausible


@pytest.fixture(scope="module")
def marked(chest) -> Fiducials:
    """All that was marked in the chest: balls on the skin, and nipples at the breasts' tips."""
    listed = chest.listed()
    names = (*(f"chest_{n}" for n in range(1, 5)), *listed.names)
    return Fiducials(names, ("chest",) * 4 + listed.kinds, np.vstack([chest.chest, listed.points]))


def changed(listed: Fiducials, change=lambda points: points, **moved) -> Fiducials:
    points = np.array(change(listed.points), float)
    for name, place in moved.items():
        points[listed.names.index(name)] = place
    return Fiducials(listed.names, listed.kinds, points)


def test_points_on_the_skin_pass_and_are_near_it(chest, marked):
    require_plausible(marked, chest.image)
    # Voxels of 4 mm, balls of 7 mm that may count as body, breasts as balls: within a voxel and a radius.
    assert np.abs(Skin.of(chest.image).at(marked.points)).max() < 7.5


def test_the_distance_is_that_to_the_outline_with_its_sign(chest):
    skin = Skin.of(chest.image)
    depths = np.array([[65.0, y, 0.0] for y in (-75, -65, -45)])  # of a ball of 50 mm about (65, -15, 0)
    np.testing.assert_allclose(skin.at(depths), [10, 0, -20], atol=4.0)  # a voxel
    assert np.isnan(skin.at(np.array([[900.0, 900, 900]]))).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p: p * [-1, -1, 1], "with the signs of x and y reversed, 10 of 10 lie on it: they are RAS"),
        (lambda p: p / 1000, r"multiplied by 1000, 10 of 10 lie on it: given in metres"),
        (lambda p: p / 10, r"multiplied by 10, 10 of 10 lie on it: given in cm"),
        (lambda p: p * 1000, r"divided by 1000, 10 of 10 lie on it: given in um"),
        (lambda p: p * [-1e-3, -1e-3, 1e-3], r"in metres, with the signs of x and y reversed"),
    ],
)
def test_one_mistake_in_all_points_is_named_with_the_next_step(chest, marked, change, words):
    with pytest.raises(FiducialError, match=f"far from the skin of the image; {words}") as caught:
        require_plausible(changed(marked, change), chest.image)
    assert "\n" not in str(caught.value)


def test_voxel_numbers_are_told_from_millimetres(chest, marked):
    voxels = chest.image.grid.indices(marked.points)[:, ::-1]
    with pytest.raises(FiducialError, match="taken as voxel numbers, 10 of 10 lie on it"):
        require_plausible(changed(marked, lambda _: voxels), chest.image)


def test_an_image_that_stands_on_its_head_is_found_by_its_points(marked, render):
    # Breasts above the middle of the image, so that its two ends differ.
    chest = render(4.0, low=(-164, -100, -90), high=(164, 70, 150))
    require_plausible(changed(marked), chest.image)
    flipped = Image(chest.image.grid, chest.image.values[::-1].copy())
    with pytest.raises(FiducialError, match=r"mirrored head to feet, 10 of 10 lie on it: .* upside down"):
        require_plausible(marked, flipped)


def test_an_image_that_is_the_wrong_way_round_is_found_by_its_points(marked, chest):
    flipped = Image(chest.image.grid, chest.image.values[:, ::-1].copy())
    with pytest.raises(
        FiducialError, match=r"mirrored front to back, \d+ of 10 lie on it: .* wrong way round"
    ):
        require_plausible(marked, flipped)


def test_a_list_that_is_mirrored_is_found_in_an_image_that_reaches_farther_on_one_side(marked, render):
    chest = render(4.0, low=(-164, -100, -90), high=(244, 70, 90))
    mirrored = changed(marked, lambda p: [80, 0, 0] + p * [-1, 1, 1])
    with pytest.raises(FiducialError, match=r"mirrored left to right, 10 of 10 lie on it: .* mirrored"):
        require_plausible(mirrored, chest.image)


def test_points_that_are_near_each_other_are_two(chest, marked):
    beside = marked.point("breast_1") + [3.0, 0, 0]
    require_plausible(changed(marked, breast_2=beside), chest.image)


def test_one_point_in_the_air_under_the_skin_or_outside_is_named(chest, marked):
    for place, words in (
        ((65, -95, 0), r"nipple_left is \d+ mm from the skin, in the air; .* mark anew in this image"),
        ((65, -30, 0), r"nipple_left is \d+ mm under the skin"),
        ((900, 900, 900), r"nipple_left is outside the image; .* ends at x -164 to 164"),
    ):
        with pytest.raises(FiducialError, match=f"^{words}"):
            require_plausible(changed(marked, nipple_left=place), chest.image)


def first_off(chest, away: float, *, x: float, z: float) -> np.ndarray:
    """In front of the skin at x, z, the first place that is so far from it, mm."""
    ahead = np.array([[x, y, z] for y in np.arange(0.0, -100.0, -0.25)])
    return ahead[np.argmax(Skin.of(chest.image).at(ahead) > away)]


def test_a_point_may_be_8_mm_and_half_a_voxel_off_the_skin(chest, marked):
    require_plausible(changed(marked, nipple_left=first_off(chest, 9.0, x=65, z=0)), chest.image)
    with pytest.raises(FiducialError, match="nipple_left is 11 mm from the skin, in the air"):
        require_plausible(changed(marked, nipple_left=first_off(chest, 10.5, x=65, z=0)), chest.image)


def test_points_that_span_one_axis_alone_are_in_metres_as_others_are(chest):
    points = np.array([first_off(chest, 0.0, x=0, z=z) for z in (-40, 40)])
    listed = Fiducials(("chest_1", "chest_2"), ("chest",) * 2, points)
    require_plausible(listed, chest.image)
    with pytest.raises(FiducialError, match="multiplied by 1000, 2 of 2 lie on it: given in metres"):
        require_plausible(changed(listed, lambda p: p / 1000), chest.image)


def test_a_list_of_another_position_is_suspected_where_the_breasts_differ_and_the_chest_does_not(
    chest, marked
):
    flat = changed(marked, nipple_left=(65, -40, 0), nipple_right=(-65, -40, 0))
    with pytest.raises(FiducialError, match="marked in the image of another position"):
        require_plausible(flat, chest.image)


def test_a_point_at_zero_that_is_not_on_the_skin_was_never_placed(chest, marked):
    moved = changed(marked, lambda p: p + [0, 60, 0])  # the skin of the breastbone is near y = -7 mm
    grid = chest.image.grid
    image = Image(type(grid)(grid.shape, grid.spacing, grid.origin + [0, 60, 0]), chest.image.values)
    require_plausible(moved, image)
    with pytest.raises(FiducialError, match=r"breast_1 .* at 0 0 0: was it placed"):
        require_plausible(changed(moved, breast_1=(0, 0, 0)), image)


def test_a_point_at_zero_may_lie_on_the_skin(chest, marked):
    nearest = marked.points[np.argmin(np.abs(Skin.of(chest.image).at(marked.points)))]
    grid = chest.image.grid
    image = Image(type(grid)(grid.shape, grid.spacing, grid.origin - nearest), chest.image.values)
    require_plausible(changed(marked, lambda p: p - nearest), image)


def test_two_names_do_not_stand_for_one_place(chest, marked):
    copied = changed(marked, breast_2=marked.point("breast_1") + 0.2)
    with pytest.raises(FiducialError, match=r"^breast_1 and breast_2 lie at one place, 0\.35 mm apart; mark"):
        require_plausible(copied, chest.image)


def test_left_is_left(chest, marked):
    left, right = (marked.point(f"nipple_{side}") for side in ("left", "right"))
    with pytest.raises(FiducialError, match=r"^nipple_left lies to the right of nipple_right, .* exchange"):
        require_plausible(changed(marked, nipple_left=right, nipple_right=left), chest.image)


def test_nothing_is_asked_of_points_that_are_not_listed(chest, marked):
    one = Fiducials(marked.names[-2:-1], marked.kinds[-2:-1], marked.points[-2:-1])
    require_plausible(one, chest.image)
