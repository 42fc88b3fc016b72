"""How the files of a position were read, in words for a person who looks at them before a run.

Nothing here can be a patient's name: series are told by numbers and words of a fixed list, codes by tissues.
"""

from collections.abc import Mapping
from pathlib import Path

from mammosim.core.errors import ConfigurationError
from mammosim.core.units import MM3_PER_CM3
from mammosim.io.dicom import Series, is_series
from mammosim.io.dicom_stack import RESAMPLE
from mammosim.io.label_codes import OWN, is_preset
from mammosim.io.label_maps import CodedMap, meanings

NONE = "no tissue"
# The first letters of the tag PatientPosition, and what the last one says of how she lay.
FIRST = {"HF": "head first", "FF": "feet first"}
LYING = {"P": "prone", "S": "supine", "DL": "on her left", "DR": "on her right"}


def codes_read(coded: CodedMap, codes: str) -> dict[str, str]:
    """Who explains the codes of a label map, and each code that a voxel has: '1: adipose, 423 cm3'."""
    try:
        meaning: Mapping[int, str] = meanings(coded, codes)
    except ConfigurationError:  # which is a reason to stop
        meaning = {}
    unit = coded.grid.voxel_volume / MM3_PER_CM3
    each = (
        f"{code}: {meaning.get(code) or NONE}, {count * unit:.3g} cm3" for code, count in coded.counts.items()
    )
    return {"codes": _by_whom(coded, codes), "codes found": "; ".join(each)}


def _by_whom(coded: CodedMap, codes: str) -> str:
    if is_preset(codes):
        return f"preset {codes}, as the column codes says"
    if codes:
        return f"as {codes} says, which the column codes names"
    if coded.names:
        return "as the names of its own segments say; the column codes is empty"
    return f"the program's own (preset {OWN}): the column codes is empty, and the file names no segments"


def series_read(scan: Series, *, series: str, gaps: str) -> dict[str, str]:
    """Which series and phase was read and why that one, and what was done about uneven slices."""
    if not scan.chosen:
        return {}
    by = f"as the column series says ({series})" if series else "the only volume there is"
    even = "as they are; slices that are not even would be rejected"
    resampled = "uneven slices are interpolated onto an even grid, as the column gaps says"
    return {"series": f"{scan.chosen}; {by}", "gaps": resampled if gaps == RESAMPLE else even}


def orientation_read(path: str, patient_position: str | None = None, *, listed: bool = False) -> str:
    """Where her head and her left are taken to be, and who says so: most bodies look alike when mirrored.

    listed: whether points that somebody marked were compared with the body.
    """
    if patient_position:
        who = f"as the tags of the slices say ({_lying(patient_position)})"
    elif is_series(path):
        who = "as the tags of the frames say"
    elif Path(path).name.lower().endswith((".nii", ".nii.gz")):
        who = "as the header's sform or qform says"
    else:
        who = "as the file's header says"
    points = "; the listed points were compared with it" if listed else ""
    return (
        f"her head towards larger z (S in the pictures) and her left towards larger x (L), {who}{points}; a "
        "body whose ends look alike shows no exchange: compare the pictures with what you know of her"
    )


def _lying(tag: str) -> str:
    """'HFP, head first, prone'."""
    words = [FIRST.get(tag[:2].upper(), ""), LYING.get(tag[2:].upper(), "")]
    return ", ".join(filter(None, [tag[:4], *words]))
