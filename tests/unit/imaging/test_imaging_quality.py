"""An image is rejected when the breast is cut off or its position cannot be what it claims."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, Image, grid_around
from mammosim.imaging.outline import body_mask
from mammosim.imaging.quality import (
    image_quality,
    position_seen,
    require_intensities,
    require_usable,
    shows_one_breast,
)

PRONE, SUPINE = np.array([0.0, -1.0, 0.0]), np.array([0.0, 1.0, 0.0])


def test_the_outline_encloses_the_body(chest) -> None:
    body = body_mask(chest.image)
    truth = ~np.isin(chest.labels.values, [Label.AIR, Label.MARKER])
    # At most a quarter of the voxels on the surface (an 8th of this body's) may be decided the other way.
    assert np.count_nonzero(body != truth) < 0.03 * truth.sum()


def test_a_whole_breast_in_its_position_is_usable(chest) -> None:
    require_usable(chest.image, position="prone", gravity=PRONE, patient_position="HFP")
    require_usable(chest.image, position="prone", gravity=np.array([1.0, -9.8, 1.0]), patient_position="FFP")
    require_usable(
        chest.image, position="supine_tilted", gravity=np.array([0.7, 0.7, 0]), patient_position="HFS"
    )


@pytest.mark.parametrize(
    ("position", "gravity", "tag", "message"),
    [
        ("prone", SUPINE, None, r"'prone' contradicts gravity .* 180 degrees .* the limit is 60"),
        ("supine", PRONE, "HFS", "'supine' contradicts gravity"),
        ("prone", PRONE, "HFS", "contradicts the PatientPosition tag 'HFS'; its third letter must be 'P'"),
        ("supine_tilted", np.array([0.7, 0.7, 0]), "FFP", "contradicts the PatientPosition tag 'FFP'"),
    ],
)
def test_a_position_that_contradicts_gravity_or_tag_is_rejected(
    chest, position, gravity, tag, message
) -> None:
    with pytest.raises(ImageError, match=message):
        require_usable(chest.image, position=position, gravity=gravity, patient_position=tag)


def test_gravity_must_be_a_direction(chest) -> None:
    for gravity in (np.zeros(3), np.array([np.nan, 0, 1])):
        with pytest.raises(ConfigurationError, match="is no direction; give x y z"):
            require_usable(chest.image, position="prone", gravity=gravity)


@pytest.mark.parametrize(
    ("side", "window"),
    [
        ("anterior", {"low": (-164, -52, -90)}),
        ("right", {"low": (-80, -100, -90)}),
        ("left", {"high": (90, 70, 90)}),
    ],
)
def test_a_breast_that_is_cut_off_is_rejected(render, side, window) -> None:
    scan = render(4.0, **window)
    message = rf"cuts the breast off: tissue covers \d+ mm2 of its {side} border, the limit is 50 mm2"
    with pytest.raises(ImageError, match=message):
        require_usable(scan.image, position="prone", gravity=PRONE)


def test_arms_and_sides_may_leave_the_image() -> None:
    """As where the arms lie beside the head: nearly level with the breastbone, far behind the tips."""
    image = body(stands_out_mm=80)
    side = image.values.copy()
    _, y, z = image.grid.centres().T.reshape(3, *image.grid.shape)
    side[(y > -14) & (y < 80) & (z > 50)] = 1000
    judge(Image(image.grid, side), "prone")


def test_the_quality_row_states_geometry_noise_and_margins(chest) -> None:
    row = image_quality(chest.image, position="prone")
    assert (row["spacing_z_mm"], row["extent_x_mm"], row["tilt_deg"]) == (4.0, 328.0, 0.0)
    # Noise was drawn with 20 per channel; its median over 40,000 voxels of air is known to 0.2.
    assert row["noise"] == pytest.approx(20.0, abs=1.0)
    # Breasts reach y = -65 in an image from -100, and 18 mm in front of the midline's skin at -47: one voxel.
    assert row["margin_anterior_mm"] == pytest.approx(35.0, abs=4.0)
    assert row["protrusion_left_mm"] == pytest.approx(18.0, abs=4.0)
    assert row["protrusion_right_mm"] == pytest.approx(18.0, abs=4.0)


def body(
    *,
    stands_out_mm: float,
    breasts: tuple[float, ...] = (-85.0, 85.0),
    low: float = -180,
    base_mm: float = 120,
) -> Image:
    """A slab of 320 x 80 mm with half-ellipsoids in front of it, 140 mm high, 4 mm voxels, no noise."""
    grid = grid_around(np.array([low, -100.0, -90]), np.array([180, 100.0, 90]), 4.0)
    x, y, z = grid.centres().T
    inside = (np.abs(x) < 160) & (y > 0) & (y < 80)
    for centre in breasts:
        inside |= (y < 10) & (
            ((x - centre) / base_mm * 2) ** 2 + (y / stands_out_mm) ** 2 + (z / 70) ** 2 < 1
        )
    return Image(grid, np.where(inside, 1000, 10).reshape(grid.shape).astype(np.float32))


def judge(image: Image, position: str, tag: str | None = None) -> None:
    gravity = PRONE if position == "prone" else SUPINE
    require_usable(image, position=position, gravity=gravity, patient_position=tag)


@pytest.mark.parametrize(
    ("stands_out_mm", "position", "message"),
    [
        (
            16,
            "prone",
            r"it looks supine, not prone: the breasts stand out 1\d mm .*; at least 20 mm and 0\.35;",
        ),
        (8, "prone", "it looks supine, not prone"),
        (28, "prone", r"it looks supine, not prone: .* stand out 2\d mm .*, 0\.2\d of their width; at least"),
        (90, "supine", r"it looks prone, not supine: .* stand out [78]\d mm .*; at most 60 mm and 0\.6;"),
    ],
)
def test_breasts_that_do_not_hang_or_lie_as_claimed_are_rejected(stands_out_mm, position, message) -> None:
    """Half of an ellipse of 120 mm is 104 mm wide at half of its height: 28 mm is 0.27 of that."""
    image = body(stands_out_mm=stands_out_mm)
    with pytest.raises(ImageError, match=message):
        judge(image, position)
    other = {"prone": "supine", "supine": "prone"}[position]
    judge(image, other)
    assert image_quality(image, position=position)["position_seen"] == other


def test_margins_and_protrusions_are_of_her_own_sides() -> None:
    """A left breast alone, x growing to the left, in an image that ends nearer to her right side."""
    row = image_quality(body(stands_out_mm=60, breasts=(85.0,), low=-168), position="prone")
    assert row["protrusion_left_mm"] > 40 > 8 > row["protrusion_right_mm"]
    assert row["margin_right_mm"] == pytest.approx(8, abs=4)
    assert row["margin_left_mm"] == pytest.approx(20, abs=4)


def test_a_tilted_supine_woman_is_judged_as_a_supine_one() -> None:
    with pytest.raises(ImageError, match="it looks prone, not supine_tilted"):
        judge(body(stands_out_mm=90), "supine_tilted")


def test_where_it_cannot_be_seen_how_she_lay_the_claim_is_believed_and_said(caplog) -> None:
    caplog.set_level("INFO")
    image = body(stands_out_mm=48)
    for position in ("prone", "supine"):
        judge(image, position)
        assert f"position {position} cannot be seen: the breasts stand out 4" in caplog.text
    assert image_quality(image, position="prone")["position_seen"] == "not told"


@pytest.mark.parametrize("stands_out_mm", [28, 40])
def test_small_breasts_that_hang_are_prone(stands_out_mm) -> None:
    """Of a base of 80 mm and less, as hanging tissue draws together."""
    judge(body(stands_out_mm=stands_out_mm, base_mm=80), "prone")


def test_the_scanners_tag_is_believed(caplog) -> None:
    caplog.set_level("INFO")
    judge(body(stands_out_mm=16), "prone", "HFP")
    assert "position prone is believed by its tag HFP" in caplog.text


def test_one_breast_beside_which_the_image_ends_is_usable() -> None:
    """As a sagittal series of one side, which ends at the breastbone."""
    for stands_out_mm in (30, 60):
        image = body(stands_out_mm=stands_out_mm, breasts=(85.0,), low=0)
        judge(image, "prone")
        assert image_quality(image, position="prone")["position_seen"] == "not told"
        assert shows_one_breast(image)
    assert not shows_one_breast(body(stands_out_mm=60))
    with pytest.raises(ImageError, match=r"cuts the breast off: tissue covers \d+ mm2 of its right border"):
        judge(body(stands_out_mm=60, breasts=(85.0,), low=70), "prone")


@pytest.mark.parametrize(
    ("factor", "guess"),
    [
        (0.1, r"are its lengths in cm\?"),
        (1e-3, r"in m \(or in mm, and declared as micrometres\)\?"),
        (1 / 25.4, r"in cm or inches\?"),
        (1e3, "in micrometres"),
    ],
)
def test_an_image_in_another_unit_is_rejected(factor, guess) -> None:
    image = body(stands_out_mm=60)
    grid = Grid(image.grid.shape, image.grid.spacing * factor, image.grid.origin * factor)
    with pytest.raises(ImageError, match=rf"mm large.*{guess}.* 80 to 1000 mm wide or deep; export it in mm"):
        judge(Image(grid, image.values), "prone")


@pytest.mark.parametrize("mirrored", [False, True])
def test_one_breast_that_hangs_tells_how_she_lay_on_either_side(mirrored) -> None:
    """As after a mastectomy: a chest 300 mm wide, and on one side 75 mm of breast, 50 mm wide."""
    body = np.zeros((10, 40, 60), bool)
    body[:, 25:], body[:, 10:25, 40:50] = True, True
    assert position_seen(body[..., ::-1] if mirrored else body, np.full(3, 5.0)) == "prone"


def test_an_image_of_one_value_is_no_map_of_labels() -> None:
    """It has no body, which is said elsewhere; two values are a map."""
    grid = Grid((4, 4, 4), np.full(3, 50.0), np.zeros(3))
    values = np.full(grid.shape, 7.0, np.float32)
    require_intensities(Image(grid, values))
    values[0] = 8.0
    with pytest.raises(ImageError, match="it has 2 values, from 7 to 8, as a map of labels"):
        require_intensities(Image(grid, values))
