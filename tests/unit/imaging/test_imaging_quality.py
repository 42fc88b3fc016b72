"""An image is rejected when the breast is cut off or its position cannot be what it claims."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.labels import Label
from mammosim.imaging.outline import body_mask
from mammosim.imaging.quality import image_quality, require_usable

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


def test_the_quality_row_states_geometry_noise_and_margins(chest) -> None:
    row = image_quality(chest.image, position="prone")
    assert (row["spacing_z_mm"], row["extent_x_mm"], row["tilt_deg"]) == (4.0, 328.0, 0.0)
    # Noise was drawn with 20 per channel; its median over 40,000 voxels of air is known to 0.2.
    assert row["noise"] == pytest.approx(20.0, abs=1.0)
    # Breasts reach y = -65 in an image from -100, and 18 mm in front of the midline's skin at -47: one voxel.
    assert row["margin_anterior_mm"] == pytest.approx(35.0, abs=4.0)
    assert row["protrusion_left_mm"] == pytest.approx(18.0, abs=4.0)
    assert row["protrusion_right_mm"] == pytest.approx(18.0, abs=4.0)
