"""A person's label map made ready to be meshed: what cannot be meant is rejected, what is mended is said.

Frame of the labels: LPS, mm, axes near x to the left, y to posterior, z to superior.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from scipy import ndimage

from mammosim.chain.label_geometry import (
    MIDLINE_MM,
    among,
    filled_in,
    is_outside,
    middle_of,
    overhanging,
    touching,
)
from mammosim.core.errors import ImageError
from mammosim.core.labels import DEFORMABLE, LEAST_PIECE, Label
from mammosim.core.settings import Limits
from mammosim.core.units import MM3_PER_CM3
from mammosim.core.volume import LabelMap
from mammosim.io.label_codes import BREAST, IGNORE, fits
from mammosim.io.label_maps import CodedMap, tissue_map

SOFT = (*DEFORMABLE, BREAST)
FATTY = (Label.ADIPOSE, Label.GLANDULAR, BREAST)
OPEN = (Label.AIR, Label.MARKER)
PERCENT = 100.0
PIECES = 2  # at most: the two breasts, where nothing of the body joins them
# ASSUME: no tissue has a tenth of its voxels without any neighbour of soft tissue.
LONELY = 0.1
# ASSUME: less than 50 mm2 of tissue on the front border is noise, as in an image.
CUT_MM2 = 50.0
# ASSUME: a breast is what stands out in front of the breastbone's skin; where that is less than a tenth of
# the tissue, it holds one breast, and all of it is breast.
STANDS_OUT = 0.1


@dataclass(frozen=True)
class LabelSettings:
    """`labels`: codes, a preset or a file that explains them, '' for what the map says itself.

    glandularity_percent: of a breast whose map has one code for fat and gland.
    """

    glandularity_percent: Annotated[float, Limits(above=0, below=100)]
    codes: str = ""


@dataclass(frozen=True)
class Prepared:
    """Labels of core.labels that can be meshed, and what was done to them, a sentence each."""

    labels: LabelMap
    notes: tuple[str, ...]


Step = Callable[[LabelMap, LabelSettings], tuple[LabelMap, str]]


def prepared(coded: CodedMap, settings: LabelSettings) -> Prepared:
    """The labels. Raises ImageError, which names the file: unknown codes, no breast, cut off, in pieces."""
    labels = tissue_map(coded, settings.codes)
    notes = _overlaps(coded)
    for step in STEPS:
        try:
            labels, note = step(labels, settings)
        except ImageError as error:
            unsaid = step in DOUBTED and not (settings.codes or coded.names)
            also = (
                f"; if the codes are others, say so in the column codes ({fits(coded.found)})"
                if unsaid
                else ""
            )
            raise ImageError(f"{coded.path}: {error}{also}") from None
        notes += [note] if note else []
    return Prepared(labels, tuple(notes))


def _overlaps(coded: CodedMap) -> list[str]:
    """What was done where several segments lie over each other."""
    volume = coded.overlapping * coded.grid.voxel_volume / MM3_PER_CM3
    said = f"{volume:.2g} cm3 ({coded.overlapping} voxels) lie in several segments: the smallest one is kept"
    return [said] if coded.overlapping else []


def _require_breast(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    if not among(labels.values, FATTY).any():
        raise ImageError("no voxel is labelled as adipose or glandular; give the labels of a breast")
    return labels, ""


def _require_whole(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """Nothing touches the front border; a single breast may be cut at the midline, where it is held."""
    dx, _, dz = labels.grid.spacing
    cut = np.count_nonzero(among(labels.values[:, 0], SOFT)) * dx * dz
    if cut > CUT_MM2:
        raise ImageError(
            f"the breast is cut off at the front border, where {cut:.0f} mm2 of tissue touch it; "
            "give a map of the whole breast"
        )
    rows = np.flatnonzero(among(labels.values, SOFT).any(axis=(0, 2)))
    near = rows[0] == 1
    return (
        labels,
        "tissue begins one voxel behind the front border: see that the breast is whole" if near else "",
    )


def _require_solid(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    soft = among(labels.values, SOFT)
    near = np.zeros_like(soft)
    for axis in range(3):
        ahead, behind = (
            tuple(s if a == axis else slice(None) for a in range(3)) for s in (slice(1, None), slice(-1))
        )
        near[ahead] |= soft[behind]
        near[behind] |= soft[ahead]
    lonely = np.count_nonzero(soft & ~near) / np.count_nonzero(soft)
    if lonely > LONELY:
        raise ImageError(
            f"{PERCENT * lonely:.0f} % of the voxels of tissue have no neighbour of tissue, as in "
            "noise; smooth the labels, or export them again"
        )
    return labels, ""


def _require_meant(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """The rib cage is not inside the breast, and no marker is: then these are codes of something else."""
    for label in (Label.THORAX, Label.MARKER):
        mask = labels.values == label
        if mask.any() and not is_outside(mask, labels.values == Label.AIR):
            raise ImageError(
                f"what is labelled as {label.tissue} lies inside the breast, where there is none; correct it"
            )
    return labels, ""


def _labelled(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """Voxels to be ignored take the label of the nearest other voxel."""
    unknown = labels.values == IGNORE
    return filled_in(labels, unknown), _said(unknown, labels, "that are to be ignored take the nearest label")


def _lesions(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    # ASSUME: a lesion is as stiff, and attenuates, as gland.
    lesion = labels.values == Label.LESION
    values = np.where(lesion, np.uint8(Label.GLANDULAR), labels.values)
    return replace(labels, values=values), _said(lesion, labels, "of lesions are taken as gland")


def _one_body(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """Without strays; two breasts that nothing joins are both kept."""
    pieces, _ = ndimage.label(among(labels.values, SOFT))
    size = np.bincount(pieces.ravel())
    size[0] = 0
    kept = np.flatnonzero(size >= LEAST_PIECE * size.max())
    unit = labels.grid.voxel_volume / MM3_PER_CM3
    if len(kept) > PIECES:
        volumes = ", ".join(f"{volume:.0f}" for volume in sorted(size[kept] * unit, reverse=True))
        raise ImageError(
            f"the tissue falls into {len(kept)} pieces of {volumes} cm3 that do not touch; label "
            "what joins them"
        )
    stray = (pieces > 0) & ~np.isin(pieces, kept)
    n = np.count_nonzero(size) - len(kept)
    note = _said(stray, labels, f"in {n} stray pieces of tissue are dropped")
    if len(kept) == PIECES:
        least = size[kept].min() * unit
        apart = f"a piece of {least:.0f} cm3 is not connected to the rest, and is held by itself"
        note = "; ".join(filter(None, [note, apart]))
    outside = np.where(
        touching(pieces, labels.values == Label.AIR), np.uint8(Label.AIR), np.uint8(Label.THORAX)
    )
    return replace(labels, values=np.where(stray, outside, labels.values)), note


def _closed(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """Holes that tissue encloses take the nearest tissue."""
    pieces, n = ndimage.label(~among(labels.values, SOFT))
    border = np.unique(
        np.concatenate([pieces.take(end, axis).ravel() for axis in range(3) for end in (0, -1)])
    )
    hole = (pieces > 0) & ~np.isin(pieces, border)
    n -= np.count_nonzero(border)
    return filled_in(labels, hole), _said(hole, labels, f"in {n} holes are filled with the nearest tissue")


def _chest_wall(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """Air behind muscle, or behind the last tissue, is the chest, which holds it: both may have one code.

    Behind the free back of a hanging breast, and behind skin, it stays air.
    """
    values = labels.values
    index = np.arange(values.shape[1], dtype=np.int16)[None, :, None]
    solid = np.where(among(values, OPEN), np.int16(-1), index)
    ahead = np.maximum.accumulate(solid, axis=1)
    last = np.where(among(values, SOFT), index, np.int16(-1)).max(axis=1)
    front = np.take_along_axis(values, np.maximum(ahead, 0), axis=1)
    behind_all = (index > last[:, None]) & ~overhanging(last, labels)[:, None]
    held = (front == Label.MUSCLE) | (behind_all & among(front, FATTY))
    chest = (values == Label.AIR) & (ahead >= 0) & held
    note = _said(chest, labels, "behind the tissue are taken as chest, which holds it")
    return replace(labels, values=np.where(chest, np.uint8(Label.THORAX), values)), note


def _mixed(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    """Breast is fat where gland is labelled, too; else its innermost part is gland."""
    breast = labels.values == BREAST
    values = np.where(breast, np.uint8(Label.ADIPOSE), labels.values)
    if not breast.any():
        return replace(labels, values=values), ""
    if (labels.values == Label.GLANDULAR).any():
        return replace(labels, values=values), _said(
            breast, labels, "of breast around the gland are taken as fat"
        )
    values[_innermost(breast, labels, settings.glandularity_percent / PERCENT)] = Label.GLANDULAR
    return replace(labels, values=values), (
        f"fat and gland share a code: the innermost {settings.glandularity_percent:g} % of each breast are "
        "taken as gland (labels.glandularity_percent)"
    )


def _innermost(breast: np.ndarray, labels: LabelMap, share: float) -> np.ndarray:
    """The deepest part (nz, ny, nx) of what stands out in front of the breastbone, on each side of it."""
    # ASSUME: gland is where a breast is deepest, as it is on average; no map of it alone can tell.
    step = labels.grid.spacing[::-1]
    box = ndimage.find_objects(breast.astype(np.uint8))[0]
    depth = np.zeros(breast.shape, np.float32)
    depth[box] = ndimage.distance_transform_edt(np.pad(breast[box], 1), sampling=step)[1:-1, 1:-1, 1:-1]
    middle = int(middle_of(np.array([box[2].start, box[2].stop])))
    near = max(1, int(MIDLINE_MM / step[2]))
    strip: np.ndarray = np.any(breast[:, :, middle - near : middle + near], axis=2)
    sternum = np.median(strip.argmax(axis=1)[np.any(strip, axis=1)]) if strip.any() else 0
    out = breast & (np.arange(breast.shape[1]) < sternum)[None, :, None]
    out = out if out.sum() > STANDS_OUT * breast.sum() else breast
    found = np.zeros_like(breast)
    for side in (slice(None, middle), slice(middle, None)):
        inside = depth[..., side][out[..., side]]
        if len(inside):
            found[..., side] = out[..., side] & (depth[..., side] > np.quantile(inside, 1 - share))
    return found


def _skin(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    skin = labels.values == Label.SKIN
    said = _said(skin, labels, "of skin count as fat under a membrane of tissues.skin.thickness_mm")
    return labels, said or (
        "no skin is labelled: the outermost tissues.skin.thickness_mm of what is labelled are skin"
    )


def _muscle(labels: LabelMap, settings: LabelSettings) -> tuple[LabelMap, str]:
    absent = not (labels.values == Label.MUSCLE).any()
    return labels, "no muscle is labelled: the chest holds what lies on it" if absent else ""


def _said(mask: np.ndarray, labels: LabelMap, what: str) -> str:
    """'12 cm3 ...', nothing where the mask is empty."""
    volume = np.count_nonzero(mask) * labels.grid.voxel_volume / MM3_PER_CM3
    return f"{volume:{'.0f' if volume >= 10 else '.2g'}} cm3 {what}" if volume else ""


DOUBTED: tuple[Step, ...] = (
    _require_breast,
    _require_meant,
)  # where the codes may be those of something else
STEPS: tuple[Step, ...] = (
    *(*DOUBTED, _labelled, _require_solid, _one_body, _require_whole, _closed, _chest_wall),
    *(_mixed, _lesions, _skin, _muscle),
)
