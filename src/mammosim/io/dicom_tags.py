"""What tags of slices must be, alone and beside each other; else one line that names the file and the tag."""

from collections.abc import Sequence

import numpy as np

from mammosim.core.errors import ImageError
from mammosim.io.dicom_planes import Plane

PIXEL_MM = (0.05, 20.0)  # below: in metres, or in centimetres
GREY = ("MONOCHROME2", "MONOCHROME1")
# What the text of a tag may be, to be shown: anything else could be a name.
CODES = {*GREY, "RGB", "PALETTE COLOR", *(f"{a}F{b}" for a in "HF" for b in ("P", "S", "DL", "DR"))}
EXPORT = "export the series again"
# Tags that slices of one volume have in common, and how many numbers; 0 for text.
COMMON = {
    "Rows": 1,
    "Columns": 1,
    "PatientPosition": 0,
    "PhotometricInterpretation": 0,
    "PixelSpacing": 2,
    "ImageOrientationPatient": 6,
}
SAME = 2e-4  # of numbers that are rounded to four decimals


def require_tags(plane: Plane) -> None:
    """Raise ImageError for what every slice needs and this one lacks, or what cannot be."""
    colours = plane.number("SamplesPerPixel", otherwise=1)
    if colours != 1 or photometric(plane) not in GREY:
        raise ImageError(
            f"{plane} is in colour (SamplesPerPixel {colours:g}, {_shown(photometric(plane))}); give the "
            "original series, in grey"
        )
    if "MOSAIC" in plane.tags.get("ImageType", ()):
        raise ImageError(f"{plane} is a mosaic of slices; export the series slice by slice")
    for keyword in ("Rows", "Columns", "BitsAllocated"):
        if plane.number(keyword) < 1:
            raise ImageError(f"{plane}: its {keyword} is not positive; {EXPORT}")
    require_place(plane)
    if not plane.number("RescaleSlope", otherwise=1):
        raise ImageError(f"{plane}: its RescaleSlope is 0, which leaves no image; {EXPORT}")
    plane.number("RescaleIntercept", otherwise=0)


def photometric(plane: Plane) -> str:
    """What the values of a slice stand for; MONOCHROME2 where it does not say."""
    return str(plane.tags.get("PhotometricInterpretation", GREY[0]))


def is_inverse(planes: Sequence[Plane]) -> bool:
    """Whether the lowest value of a volume is white."""
    return photometric(planes[0]) == GREY[1]


def require_place(plane: Plane) -> None:
    """Raise ImageError unless position, orientation and pixels of a slice can be."""
    plane.numbers("ImagePositionPatient", 3)
    row, column = plane.numbers("ImageOrientationPatient", 6).reshape(2, 3)
    if not np.allclose([row @ row, column @ column, row @ column], [1, 1, 0], atol=1e-3):
        raise ImageError(
            f"{plane}: its ImageOrientationPatient is no pair of perpendicular unit vectors; {EXPORT}"
        )
    spacing = plane.numbers("PixelSpacing", 2)
    low, high = PIXEL_MM
    if np.any((spacing < low) | (spacing > high)):
        field = spacing * [plane.number("Rows"), plane.number("Columns")]
        unit = ", as if it were in metres" if 0 < spacing.min() < low else ""
        raise ImageError(
            f"{plane}: its PixelSpacing is {spacing[0]:g} x {spacing[1]:g} mm, a field of {field[0]:.3g} x "
            f"{field[1]:.3g} mm{unit}; correct it to {low:g} to {high:g} mm, or {EXPORT}"
        )


def require_equal(planes: Sequence[Plane], where: str) -> None:
    """Raise ImageError where a slice differs from most in a tag that a volume has once."""
    without = sum("PatientPosition" not in plane.tags for plane in planes)
    if without:
        raise ImageError(
            f"{where}: {without} of {len(planes)} slices have no PatientPosition tag (0018,5100), so that "
            "the position cannot be checked against gravity; add HFP, HFS, FFP or FFS as scanned"
        )
    for keyword, count in COMMON.items():
        values = [_value(plane, keyword, count) for plane in planes]
        usual = max(dict.fromkeys(values), key=values.count)
        odd = [k for k, value in enumerate(values) if not _close(value, usual)]
        if odd:
            raise ImageError(
                f"{planes[odd[0]]}: its {keyword} is {_shown(values[odd[0]])}, that of other slices is "
                f"{_shown(usual)} ({len(odd)} of {len(planes)} differ); a volume needs equal slices: take "
                "out localizers and other views"
            )


Value = tuple[float, ...] | str


def _value(plane: Plane, keyword: str, count: int) -> Value:
    if count:
        return tuple((np.round(plane.numbers(keyword, count), 4) + 0.0).tolist())
    return photometric(plane) if keyword == "PhotometricInterpretation" else str(plane.tags[keyword])


def _close(one: Value, other: Value) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return bool(np.allclose(np.array(one), np.array(other), rtol=0, atol=SAME))


def _shown(value: Value) -> str:
    if isinstance(value, str):
        return value if value in CODES else "something else"
    return " ".join(f"{number:g}" for number in value)
