"""Which slices of a folder are the volume that is asked for: one series of several, and one phase of it.

What is offered tells series apart by numbers and by words of a fixed list: free text may hold a name.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.errors import ImageError
from mammosim.io.dicom_phases import LEAST_PLACES, TELLING, each_once, phases_of
from mammosim.io.dicom_planes import Plane

# ASSUME: a localiser has at most three slices in one direction; a volume has more.
MOST_OF_LOCALISER = 3
LOCALISER = {"LOCALIZER", "LOCALISER", "LOC", "SCOUT", "SURVEY"}
DESCRIBING = ("SeriesDescription", "ProtocolName")
# Words of a description that are shown: of the technique, and none of them a name.
WORDS = """
T1 T2 T1W T2W PD FS FATSAT NFS SPAIR SPIR STIR DWI ADC DCE VIBE TSE FSE HASTE GRE MIP SUB AX AXIAL TRA SAG COR
PRONE SUPINE LOCALIZER LOCALISER
"""
SHOWN = frozenset(WORDS.split())
# Words of ImageType, FrameType and ComplexImageComponent that tell volumes apart.
KINDS = {"M", "P", "R", "I", "MAGNITUDE", "PHASE", "REAL", "IMAGINARY", "M_FFE", "PHASE MAP"}
KINDS |= {"W", "F", "IP", "OP", "WATER", "FAT", "IN_PHASE", "OUT_PHASE"}
NUMBER = re.compile(r"-?\d+(\.\d+)?")
MODALITIES = ("MR", "CT", "PT", "OT")
PHASE = re.compile(r"(?:(.*\S)\s+)?phase\s+(\d+)", re.IGNORECASE)
COLUMN = "the column `series`"
Groups = Sequence[Sequence[Plane]]


@dataclass(frozen=True)
class Chosen:
    """planes: of one volume, in no order; whole: their series has no others; notes: what was left out.

    told: which of all it is, in words.
    """

    planes: tuple[Plane, ...]
    whole: bool
    notes: tuple[str, ...]
    told: str


def choose(planes: Sequence[Plane], wanted: str, where: str) -> Chosen:
    """The slices of the series and phase that `wanted` names, or of the only one there is.

    wanted: '' or 'NUMBER', 'UID' or 'part of the description', with ' phase N' after it where there are
    phases. Raises ImageError, with what there is: several, or none of that name.
    """
    groups = _by_series(planes)
    named, number = _parts(wanted, groups)
    group, notes = (_named(named, groups, where), ()) if named else _only(groups, where)
    own, copies = each_once(group)
    phases, tag = phases_of(own)
    if number > len(phases) or not (number or len(phases) == 1):
        name = f"{_key(group, groups)} " if len(groups) > 1 else ""
        told = f" volumes of {len(phases[0])} slices, told apart by {tag}" if tag else " volume"
        told += _values([phase[0].tags.get(tag) for phase in phases]) if tag in TELLING else ""
        raise ImageError(
            f"{where}{name and f', series {name.strip()},'} holds {len(phases)}{told}; write '{name}phase N' "
            f"in {COLUMN} of its row, with N from 1 to {len(phases)}"
        )
    phase = f", phase {number} of {len(phases)}" if len(phases) > 1 else ""
    told = f"{_listed([group], groups)}{phase}; 1 of {len(groups)} series of the folder or file"
    return Chosen(tuple(phases[max(number - 1, 0)]), len(phases) == 1, (*notes, *copies), told)


def _values(values: Sequence[Any]) -> str:
    """What a tag is in each phase, as ' (1: 9.5, 2: 102)': numbers, and words that name no person; or ''."""
    shown = []
    for value in values:
        parts = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        words = [f"{float(part):g}" if NUMBER.fullmatch(str(part)) else str(part) for part in parts]
        shown.append(" ".join(word for word in words if NUMBER.fullmatch(word) or word in KINDS))
    told = ", ".join(f"{n}: {word}" for n, word in enumerate(shown, 1))
    return f" ({told})" if all(shown) and len(set(shown)) > 1 else ""


def _by_series(planes: Sequence[Plane]) -> list[list[Plane]]:
    groups: dict[str, list[Plane]] = {}
    for plane in planes:
        groups.setdefault(str(plane.tags.get("SeriesInstanceUID", "")), []).append(plane)
    return sorted(groups.values(), key=lambda group: _number(group[0], "SeriesNumber", 0))


def _parts(wanted: str, groups: Groups) -> tuple[str, int]:
    """The name of a series, and the number of a phase, 0 for none; a description may end in a phase, too."""
    parts = PHASE.fullmatch(wanted.strip())
    if parts is None or any(_is_named(wanted, group) for group in groups):
        return wanted.strip(), 0
    return parts[1] or "", int(parts[2])


def _is_named(name: str, group: Sequence[Plane]) -> bool:
    tags = group[0].tags
    if re.fullmatch(r"\d+", name):
        return str(tags.get("SeriesNumber", "")) == name
    text = " ".join(str(tags.get(keyword, "")) for keyword in DESCRIBING)
    return name == str(tags.get("SeriesInstanceUID", "")) or name.lower() in text.lower()


def _named(name: str, groups: Groups, where: str) -> Sequence[Plane]:
    found = [group for group in groups if _is_named(name, group)]
    if len(found) == 1:
        return found[0]
    many = f"{len(found)} series match" if found else "no series matches"
    raise ImageError(f"{where}: {many} {COLUMN} of its row; there are: {_listed(found or groups, groups)}")


def _only(groups: Groups, where: str) -> tuple[Sequence[Plane], tuple[str, ...]]:
    """The only series that can be a volume, and words on those that cannot."""
    why = [_no_volume(group, groups) for group in groups]
    left = [group for group, reason in zip(groups, why) if not reason] or groups
    if len(left) == 1:
        others = [k for k, group in enumerate(groups) if group is not left[0]]
        notes = [f"{why[k]} left out ({_listed([groups[k]], groups)})" for k in others]
        return left[0], tuple(notes)
    raise ImageError(
        f"{where} mixes {len(left)} series: {_listed(left, groups)}; name one, by its number or a part of "
        f"its description, in {COLUMN} of its row, or give each series a folder of its own"
    )


def _no_volume(group: Sequence[Plane], groups: Groups) -> str:
    """What a series is instead of a volume; '' for a volume, whole or not."""
    tags = group[0].tags
    if all("ImagePositionPatient" not in plane.tags for plane in group):
        return "pictures without a place"
    if _number(group[0], "SamplesPerPixel", 1) != 1:
        return "colour pictures"
    if "LOCALIZER" in tags.get("ImageType", ()) or LOCALISER & set(_words(tags, *DESCRIBING)):
        return "localiser"
    largest = max(groups, key=len)
    ways = _directions(group)
    several = len(ways) > 1 and max(ways.values()) < len(group) * LEAST_PLACES
    few = max(ways.values()) <= MOST_OF_LOCALISER and not set(ways) & set(_directions(largest))
    return "localiser" if several or few else ""


def _directions(group: Sequence[Plane]) -> dict[tuple[float, ...], int]:
    """How many slices stand in each orientation; () for those without one."""
    counts: dict[tuple[float, ...], int] = {}
    for plane in group:
        try:
            value = plane.numbers("ImageOrientationPatient", 6)
        except ImageError:
            value = np.zeros(0)
        way = tuple((np.round(value, 2) + 0.0).tolist())
        counts[way] = counts.get(way, 0) + 1
    return counts


def _number(plane: Plane, keyword: str, otherwise: float) -> float:
    """The value of a tag, where it can be read."""
    try:
        return plane.number(keyword, otherwise=otherwise)
    except ImageError:
        return otherwise


def _key(group: Sequence[Plane], groups: Groups) -> str:
    """What names a series: its number, or its UID where others have that number, or it has none."""
    own, *_ = numbers = [str(each[0].tags.get("SeriesNumber", "")) for each in (group, *groups)]
    if own and numbers.count(own) == 2:  # of itself, and among all
        return own
    uid = str(group[0].tags.get("SeriesInstanceUID", ""))
    return uid if re.fullmatch(r"[\d.]+", uid) else "without number and UID"


def _listed(some: Groups, groups: Groups) -> str:
    return "; ".join(f"{_key(group, groups)}: {_described(group)}" for group in some)


def _described(group: Sequence[Plane]) -> str:
    """What tells a series from others, without a word that could be a name."""
    tags = group[0].tags
    person = _words(tags, "PatientName", "PatientID")
    shown = [word for word in _words(tags, *DESCRIBING) if word in SHOWN and word not in person]
    kind = [str(tags[key]) for key in ("Modality",) if tags.get(key) in MODALITIES]
    size = (
        f"{len(group)} slice{'s' * (len(group) > 1)} of {tags.get('Rows', '?')} x {tags.get('Columns', '?')}"
    )
    try:
        spacing = [" x ".join(f"{step:.2f}" for step in group[0].numbers("PixelSpacing", 2)) + " mm"]
    except ImageError:
        spacing = []
    return ", ".join([*kind, size, *spacing, *shown])


def _words(tags: Mapping[str, Any], *keywords: str) -> list[str]:
    """The words of texts, each once, in capitals."""
    text = " ".join(str(tags.get(keyword, "")) for keyword in keywords).upper()
    return list(dict.fromkeys(re.findall(r"[^\W_]+", text)))
