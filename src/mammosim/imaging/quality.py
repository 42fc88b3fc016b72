"""What an image offers, and whether it can be used: coverage, noise, and the position it shows and claims."""

import numpy as np

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.positions import gravity_direction
from mammosim.core.volume import Image
from mammosim.imaging.outline import body_mask, bright_level, coarsened, spread

# ASSUME: gravity may differ by up to 60 degrees from the usual direction of the claimed position.
LARGEST_ANGLE_DEG = 60.0
# ASSUME: tissue that covers less than 50 mm2 of a border is noise or a marker, not a breast that is cut off.
SMALLEST_CUT_MM2 = 50.0
FINEST_MM = 1.0
# Third letter of the PatientPosition tag: prone or supine on the table (DICOM PS3.3 C.7.3.1.1.2).
THIRD_LETTER = {"prone": "P", "supine": "S", "supine_tilted": "S"}


def image_quality(image: Image, *, position: str) -> dict[str, str | float]:
    """One row: spacing, extent, tilt of the axes, noise, and the body's margins and protrusion.

    margin_*_mm: least distance of the body to that border of the image, its front half for left and right.
    protrusion_*_mm: how far that half of the chest stands out in front of the midline.
    noise: standard deviation of one channel, from the air's median (Rayleigh: median = sigma sqrt(2 ln 2)).
    """
    coarse = coarsened(image, FINEST_MM)
    body, spacing = body_mask(coarse), image.grid.spacing
    extent = spacing * image.grid.shape[::-1]
    air = image.values[~spread(body, image.grid, FINEST_MM)]
    noise = float(np.median(air) / np.sqrt(2 * np.log(2))) if air.size else float("nan")
    tilt = np.degrees(np.arccos(np.clip(np.diag(image.grid.direction).min(), -1, 1)))
    return {
        "position_claimed": position,
        **{f"spacing_{axis}_mm": float(h) for axis, h in zip("xyz", spacing)},
        **{f"extent_{axis}_mm": float(L) for axis, L in zip("xyz", extent)},
        "tilt_deg": float(tilt),
        "noise": noise,
        "fat_to_noise": bright_level(coarse) / noise if noise > 0 else float("inf"),
        **_margins(body, coarse.grid.spacing),
        **_protrusion(body, coarse.grid.spacing[1]),
    }


def require_usable(
    image: Image, *, position: str, gravity: np.ndarray, patient_position: str | None = None
) -> None:
    """Reject an image that later stages would misread; gravity (3,) in the image's frame, any length.

    Raises ImageError: the breast is cut off at the anterior or a lateral border; gravity or the
    PatientPosition tag contradicts the position. Raises ConfigurationError for an unknown position.
    """
    _require_gravity(position, np.asarray(gravity, float))
    _require_tag(position, patient_position)
    _require_whole(image, position)


def _require_gravity(position: str, gravity: np.ndarray) -> None:
    usual = gravity_direction(position)
    length = np.linalg.norm(gravity)
    if gravity.shape != (3,) or not np.isfinite(length) or length == 0:
        raise ConfigurationError(
            f"gravity {gravity.tolist()} is no direction; give x y z, e.g. 0 -1 0 for prone"
        )
    angle = np.degrees(np.arccos(np.clip(gravity @ usual / length, -1, 1)))
    if angle > LARGEST_ANGLE_DEG:
        raise ImageError(
            f"position {position!r} contradicts gravity {gravity.tolist()}: it is {angle:.0f} degrees from "
            f"the usual {usual.round(3).tolist()}, the limit is {LARGEST_ANGLE_DEG:g}; correct one of them "
            "(x to the left, y to posterior, z to superior)"
        )


def _require_tag(position: str, patient_position: str | None) -> None:
    letter = THIRD_LETTER.get(position)
    if patient_position and letter and letter != patient_position.strip().upper()[2:3]:
        raise ImageError(
            f"position {position!r} contradicts the PatientPosition tag {patient_position!r}; its third "
            f"letter must be {letter!r}: give the series of this position, or correct the position"
        )


def _require_whole(image: Image, position: str) -> None:
    coarse = coarsened(image, FINEST_MM)
    body, (dx, dy, dz) = body_mask(coarse), coarse.grid.spacing
    front = _front_half(body)
    faces = {
        "anterior": (body[:, 0, :], dx * dz),
        "right": (front[:, :, 0], dy * dz),
        "left": (front[:, :, -1], dy * dz),
    }
    for side, (face, area) in faces.items():
        cut = np.count_nonzero(face) * area
        if cut > SMALLEST_CUT_MM2:
            raise ImageError(
                f"the {position} image cuts the breast off: tissue covers {cut:.0f} mm2 of its {side} "
                f"border, the limit is {SMALLEST_CUT_MM2:g} mm2; take a series with a larger field of view"
            )


def _front_half(body: np.ndarray) -> np.ndarray:
    """The body's front half in depth; behind it arms and back may leave the image."""
    rows = np.flatnonzero(body.any(axis=(0, 2)))
    front = body.copy()
    front[:, (rows[0] + rows[-1] + 1) // 2 :, :] = False
    return front


def _margins(body: np.ndarray, spacing: np.ndarray) -> dict[str, float]:
    columns = np.flatnonzero(_front_half(body).any(axis=(0, 1)))
    rows = np.flatnonzero(body.any(axis=(0, 2)))
    return {
        "margin_anterior_mm": float(rows[0] * spacing[1]),
        "margin_right_mm": float(columns[0] * spacing[0]),
        "margin_left_mm": float((body.shape[2] - 1 - columns[-1]) * spacing[0]),
    }


def _protrusion(body: np.ndarray, dy: float) -> dict[str, float]:
    """Rows between the body's front at the midline and its foremost point on either side, times dy."""
    # ASSUME: the front is what a tenth of the slices reach: nipples and markers do not count.
    front = body.mean(axis=0) >= 0.1
    rows = np.where(front.any(axis=0), front.argmax(axis=0), front.shape[0])
    middle = int(np.flatnonzero(front.any(axis=0)).mean())
    ahead = rows[middle] - np.array([rows[:middle].min(), rows[middle + 1 :].min()])
    return {"protrusion_right_mm": float(ahead[0] * dy), "protrusion_left_mm": float(ahead[1] * dy)}
