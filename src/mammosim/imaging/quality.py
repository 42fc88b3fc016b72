"""What an image offers, and whether it can be used: coverage, noise, and the position it shows and claims."""

import logging

import numpy as np

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.positions import gravity_direction
from mammosim.core.volume import Image
from mammosim.imaging.outline import body_mask, bright_level, coarsened, spread

# ASSUME: gravity may differ by up to 60 degrees from the usual direction of the claimed position.
LARGEST_ANGLE_DEG = 60.0
# ASSUME: tissue that covers less than 50 mm2 of a border is noise or a marker, not a breast that is cut off.
SMALLEST_CUT_MM2 = 50.0
# ASSUME: what stands out less than a quarter as far as the breasts do is an arm or the side of the chest.
SIDE_PART = 0.25
FINEST_MM = 1.0
# Third letter of the PatientPosition tag: prone or supine on the table (DICOM PS3.3 C.7.3.1.1.2).
THIRD_LETTER = {"prone": "P", "supine": "S", "supine_tilted": "S"}
# ASSUME: an image of a chest is 80 to 1000 mm wide or deep; a chest is 250 to 500 mm wide, one breast 100.
SMALLEST_VIEW_MM, LARGEST_VIEW_MM = 80.0, 1000.0
UNITS_MM = {
    "cm": 10.0,
    "inches": 25.4,
    "m (or in mm, and declared as micrometres)": 1000.0,
    "micrometres (or in mm, and declared as m)": 1e-3,
    "tenths of mm": 0.1,
}
# ASSUME: breasts hang only where they stand out 20 mm or more in front of the breastbone, and 0.35 or more of
# their width at half of that; they lie only up to 60 mm and 0.6. Digital volunteers: 36 to 64 mm and 0.48 to
# 0.63 prone, 24 to 30 mm and 0.30 supine, up to 42 mm and 0.40 tilted, by the breast that stands out more.
LEAST_HANGING, LARGEST_LYING = (20.0, 0.35), (60.0, 0.6)
# ASSUME: what is less than 200 mm wide, and recedes nowhere by 10 mm between two tips, is one breast; the
# skin beside it, where the image may end, is 20 mm or more behind its tip.
ONE_BREAST_MM, VALLEY_MM, BESIDE_MM = 200.0, 10.0, 20.0
# ASSUME: an image has more than 16 intensities; a map of labels has as many as it has tissues, or segments.
MOST_CODES, SAMPLED = 16, 1_000_000
NOT_TOLD = "not told"
log = logging.getLogger(__name__)


def image_quality(image: Image, *, position: str) -> dict[str, str | float]:
    """One row: spacing, extent, tilt of the axes, noise, and the body's margins and protrusion.

    position_seen: prone, supine, or NOT_TOLD, by how far the breasts stand out.
    margin_*_mm: least distance of the body to that border of the image, its front half for left and right.
    protrusion_*_mm: how far that half of the chest stands out in front of the midline.
    noise: standard deviation of one channel, from the air's median (Rayleigh: median = sigma sqrt(2 ln 2)).
    """
    coarse = coarsened(image, FINEST_MM)
    body, spacing, spacing_of_body = body_mask(coarse), image.grid.spacing, coarse.grid.spacing
    extent = spacing * image.grid.shape[::-1]
    air = image.values[~spread(body, image.grid, FINEST_MM)]
    noise = float(np.median(air) / np.sqrt(2 * np.log(2))) if air.size else float("nan")
    tilt = np.degrees(np.arccos(np.clip(np.diag(image.grid.direction).min(), -1, 1)))
    return {
        "position_claimed": position,
        "position_seen": position_seen(body, spacing_of_body),
        **{f"spacing_{axis}_mm": float(h) for axis, h in zip("xyz", spacing)},
        **{f"extent_{axis}_mm": float(L) for axis, L in zip("xyz", extent)},
        "tilt_deg": float(tilt),
        "noise": noise,
        "fat_to_noise": bright_level(coarse) / noise if noise > 0 else float("inf"),
        **_margins(body, spacing_of_body),
        **_protrusion(body, spacing_of_body[1]),
    }


def require_usable(
    image: Image, *, position: str, gravity: np.ndarray, patient_position: str | None = None
) -> None:
    """Reject an image that later stages would misread; gravity (3,) in the image's frame, any length.

    Raises ImageError: gravity or the PatientPosition tag contradicts the position; the image is too small or
    large for a chest; the breast is cut off at the anterior or a lateral border, other than beside the one
    breast that is shown; or, where no tag says how she lay, the breasts do not hang or lie as claimed.
    Raises ConfigurationError for an unknown position.
    """
    _require_gravity(position, np.asarray(gravity, float))
    _require_tag(position, patient_position)
    _require_size(image)
    coarse = coarsened(image, FINEST_MM)
    body = body_mask(coarse)
    _require_whole(body, coarse.grid.spacing, position)
    _require_look(body, coarse.grid.spacing, position, patient_position)


def require_intensities(image: Image) -> None:
    """Raise ImageError for what is no image but a map of labels, which has a few values."""
    values = image.values.reshape(-1)
    found = np.unique(values[:: 1 + values.size // SAMPLED])
    if 1 < found.size <= MOST_CODES:
        raise ImageError(
            f"it has {found.size} values, from {found[0]:g} to {found[-1]:g}, as a map of labels; name it "
            "in the column labels, and give the image that it was drawn in, or none"
        )


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


def _require_size(image: Image) -> None:
    view = image.grid.spacing * image.grid.shape[::-1]
    wide = float(view[:2].max())
    if SMALLEST_VIEW_MM <= wide <= LARGEST_VIEW_MM:
        return
    fits = [name for name, mm in UNITS_MM.items() if 100 <= wide * mm <= 700]
    guess = f": are its lengths in {' or '.join(fits)}?" if fits else ":"
    raise ImageError(
        f"the image is {' x '.join(f'{length:.3g}' for length in view)} mm large{guess} One of a chest is "
        f"{SMALLEST_VIEW_MM:g} to {LARGEST_VIEW_MM:g} mm wide or deep; export it in mm, or declare its unit"
    )


def _require_whole(body: np.ndarray, spacing: np.ndarray, position: str) -> None:
    dx, dy, dz = spacing
    front, h, one = (
        body[:, : _rows_of_breasts(body, spacing)],
        _height(body, dy),
        _is_one_breast(body, spacing),
    )
    ends = {"right": h[0], "left": h[-1]}
    beside = [side for side, end in ends.items() if one and h.max() - end >= BESIDE_MM]
    faces = {
        "anterior": (body[:, 0, :], dx * dz),
        "right": (front[:, :, 0], dy * dz),
        "left": (front[:, :, -1], dy * dz),
    }
    for side, (face, area) in faces.items():
        cut = np.count_nonzero(face) * area
        if cut > SMALLEST_CUT_MM2 and side not in beside:
            raise ImageError(
                f"the {position} image cuts the breast off: tissue covers {cut:.0f} mm2 of its {side} "
                f"border, the limit is {SMALLEST_CUT_MM2:g} mm2; take a series with a larger field of view"
            )


def _rows_of_breasts(body: np.ndarray, spacing: np.ndarray) -> int:
    """How many rows, the foremost first, show breasts; farther back arms and sides may leave the image."""
    if _is_one_breast(body, spacing):
        return _middle_row(body)
    front = _front(body)
    midline = front[int(np.flatnonzero(front < body.shape[1]).mean())]
    return int(np.ceil(midline - SIDE_PART * (midline - front.min())))


def _middle_row(body: np.ndarray) -> int:
    rows = np.flatnonzero(body.any(axis=(0, 2)))
    return int(rows[0] + rows[-1] + 1) // 2


def _front_half(body: np.ndarray) -> np.ndarray:
    """The body's front half in depth; behind it arms and back may leave the image."""
    front = body.copy()
    front[:, _middle_row(body) :, :] = False
    return front


def _margins(body: np.ndarray, spacing: np.ndarray) -> dict[str, float]:
    columns = np.flatnonzero(_front_half(body).any(axis=(0, 1)))
    rows = np.flatnonzero(body.any(axis=(0, 2)))
    return {
        "margin_anterior_mm": float(rows[0] * spacing[1]),
        "margin_right_mm": float(columns[0] * spacing[0]),
        "margin_left_mm": float((body.shape[2] - 1 - columns[-1]) * spacing[0]),
    }


def position_seen(body: np.ndarray, spacing: np.ndarray) -> str:
    """How she lay, `prone` or `supine`, of a body (nz, ny, nx) bool of voxels (3,) mm; NOT_TOLD between."""
    if _is_one_breast(body, spacing):
        return NOT_TOLD
    shape = _steepness(body, spacing)
    if np.any(np.less(shape, LEAST_HANGING)):
        return "supine"
    return "prone" if np.any(np.greater(shape, LARGEST_LYING)) else NOT_TOLD


def shows_one_breast(image: Image) -> bool:
    """Whether an image shows one breast alone. Raises ImageError when no body is in the image."""
    coarse = coarsened(image, FINEST_MM)
    return _is_one_breast(body_mask(coarse), coarse.grid.spacing)


def _steepness(body: np.ndarray, spacing: np.ndarray) -> tuple[float, float]:
    """How far a breast stands out before the midline, mm, and over its width at half of that: the most."""
    front = _front(body)
    middle = int(np.flatnonzero(front < body.shape[1]).mean())
    h = (front[middle] - front) * spacing[1]
    sides = [side for side in (h[:middle], h[middle + 1 :]) if side.max(initial=0) > 0]
    steep = [side.max() / (np.count_nonzero(side >= side.max() / 2) * spacing[0]) for side in sides]
    return float(h.max()), float(max(steep, default=0))


def _require_look(body: np.ndarray, spacing: np.ndarray, position: str, patient_position: str | None) -> None:
    seen, claimed = position_seen(body, spacing), position.removesuffix("_tilted")
    if claimed not in ("prone", "supine") or seen == claimed:
        return
    protrusion, steep = _steepness(body, spacing)
    stand = (
        f"the breasts stand out {protrusion:.0f} mm in front of the breastbone, {steep:.2f} of their width"
    )
    if _is_one_breast(body, spacing):
        stand = "one breast is shown, and no breastbone"
    if seen == NOT_TOLD or patient_position:
        why = f"is believed by its tag {patient_position}" if patient_position else "cannot be seen"
        log.info("position %s %s: %s", position, why, stand)
        return
    least = claimed == "prone"
    (mm, share), bound = (LEAST_HANGING, "at least") if least else (LARGEST_LYING, "at most")
    raise ImageError(
        f"it looks {seen}, not {position}: {stand}; {bound} {mm:g} mm and {share:g}; correct the position, "
        "or give the scanner's DICOM series, whose PatientPosition tag is believed"
    )


def _front(body: np.ndarray) -> np.ndarray:
    """First row (nx,) of the body at each x, ny where there is none."""
    # ASSUME: the front is what a tenth of the slices reach: nipples and markers do not count.
    front = body.mean(axis=0) >= 0.1
    return np.where(front.any(axis=0), front.argmax(axis=0), front.shape[0])


def _height(body: np.ndarray, dy: float) -> np.ndarray:
    """How far (nx,) mm the front stands out before the last row of the image."""
    return (body.shape[1] - _front(body)) * dy


def _is_one_breast(body: np.ndarray, spacing: np.ndarray) -> bool:
    """Whether the body is as narrow as one breast, and its front has no valley between two."""
    h = _height(body, spacing[1])
    lower_tip = np.minimum(np.maximum.accumulate(h), np.maximum.accumulate(h[::-1])[::-1])
    wide = np.count_nonzero(h) * spacing[0]
    return bool(wide < ONE_BREAST_MM and (lower_tip - h).max() < VALLEY_MM)


def _protrusion(body: np.ndarray, dy: float) -> dict[str, float]:
    """Rows between the body's front at the midline and its foremost point on either side, times dy."""
    rows = _front(body)
    middle = int(np.flatnonzero(rows < body.shape[1]).mean())
    ahead = rows[middle] - np.array([rows[:middle].min(), rows[middle + 1 :].min()])
    return {"protrusion_right_mm": float(ahead[0] * dy), "protrusion_left_mm": float(ahead[1] * dy)}
