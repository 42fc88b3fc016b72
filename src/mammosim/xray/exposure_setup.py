"""What is irradiated, from where, with what; and the same as the compiled kernels read it.

A few boxes lie around all that is not air, so that photons cross the air between them in one exact step.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.interactions import Matter, matter
from mammosim.xray.phantom import AIR, Phantom
from mammosim.xray.source_sampling import Field, Triple
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.transport_step import MIXED, Body

WORTHWHILE = 0.1  # a split must save this share of the boxes' volume
MOST_BOXES = 6
BLOCK_MM = 10.0
PLACES = 100  # along each axis of the detector


def bounding_boxes(occupied: np.ndarray) -> np.ndarray:
    """Disjoint boxes (n_box, 3, 2), [first, last) along (z, y, x), that hold all of `occupied` (nz, ny, nx).

    Greedy: cut a box into two tight ones wherever that frees most volume, while it is worth it.
    """
    boxes = [_tight(occupied, np.array([[0, n] for n in occupied.shape]))]
    while len(boxes) < MOST_BOXES:
        splits = [_best_split(occupied, box) for box in boxes]
        saved = [_volume(box) - sum(map(_volume, halves)) for box, halves in zip(boxes, splits)]
        best = int(np.argmax(saved))
        if saved[best] < WORTHWHILE * sum(map(_volume, boxes)):
            break
        boxes[best : best + 1] = splits[best]
    return np.array(boxes)


def _tight(occupied: np.ndarray, box: np.ndarray) -> np.ndarray:
    """The smallest box around what is occupied inside `box` (3, 2)."""
    inside = occupied[tuple(slice(*span) for span in box)]
    found = []
    for axis in range(3):
        some = np.nonzero(inside.any(axis=tuple(a for a in range(3) if a != axis)))[0]
        found.append([box[axis, 0] + some[0], box[axis, 0] + some[-1] + 1])
    return np.array(found)


def _best_split(occupied: np.ndarray, box: np.ndarray) -> list[np.ndarray]:
    """The two tight boxes of least volume that a plane cuts `box` into; `box` when no plane helps."""
    inside = occupied[tuple(slice(*span) for span in box)]
    least, cut = _volume(box), None
    for axis in range(3):
        left, right = _volumes_before(inside, axis), _volumes_before(np.flip(inside, axis), axis)[::-1]
        both = left[:-1] + right[1:]
        if both.size and both.min() < least:
            least, cut = int(both.min()), (axis, int(both.argmin()) + 1)
    if cut is None:
        return [box]
    axis, place = cut
    low, high = box.copy(), box.copy()
    low[axis, 1] = high[axis, 0] = box[axis, 0] + place
    return [_tight(occupied, low), _tight(occupied, high)]


def _volumes_before(inside: np.ndarray, axis: int) -> np.ndarray:
    """Volumes (n,) of the tight boxes around slices 0..i of `inside` along one axis."""
    volume = np.arange(1, inside.shape[axis] + 1)
    for other in range(3):
        if other == axis:
            continue
        third = 3 - axis - other
        profile = np.any(inside, axis=third)  # two axes left, in their order
        profile = profile if axis < other else profile.T
        n = profile.shape[1]
        some = profile.any(axis=1)
        first = np.where(some, profile.argmax(axis=1), n)
        last = np.where(some, n - profile[:, ::-1].argmax(axis=1), 0)
        volume = volume * np.maximum(np.maximum.accumulate(last) - np.minimum.accumulate(first), 0)
    return volume


def _volume(box: np.ndarray) -> int:
    return int(np.prod(box[:, 1] - box[:, 0]))


def body_of(phantom: Phantom, tables: Matter) -> Body:
    """The phantom as the kernel reads it: blocks of voxels by kind, and a few boxes around its tissue."""
    size = np.maximum(np.round(BLOCK_MM / phantom.grid.spacing[::-1]), 1).astype(int)  # voxels along z, y, x
    voxels = _gathered(phantom.index, size)
    held = np.stack([np.any(voxels == m, axis=(3, 4, 5)) for m in range(len(phantom.materials))], axis=-1)
    kinds, kind = np.unique(held.reshape(-1, held.shape[-1]), axis=0, return_inverse=True)
    blocks = kind.reshape(held.shape[:3])
    single = np.where(kinds.sum(axis=1) == 1, kinds.argmax(axis=1), MIXED)
    mixed = (single == MIXED)[blocks]
    different, which = np.unique(voxels[mixed].reshape(-1, size.prod()), axis=0, return_inverse=True)
    tiles = np.zeros(mixed.shape, np.int32)
    tiles[mixed] = which.ravel()
    boxes = bounding_boxes((single != AIR)[blocks])  # (n_box, 3, 2) blocks along (z, y, x)
    block_mm = (size * phantom.grid.spacing[::-1])[::-1]
    corners = phantom.low + boxes.transpose(0, 2, 1)[:, :, ::-1] * block_mm
    return Body(
        _triple(phantom.low),
        _triple(block_mm),
        _triple(1 / phantom.grid.spacing),
        blocks.astype(np.uint16),
        np.stack([tables.mu[:, kind, 0].max(axis=1) for kind in kinds], axis=1),
        single,
        tiles,
        different.reshape(-1, *size),
        np.ascontiguousarray(corners.reshape(-1, 6)),
    )


def _gathered(index: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Voxels in blocks of `size`: (bz, by, bx, sz, sy, sx), with air beyond the grid."""
    padded = np.pad(index, [(0, -n % k) for n, k in zip(index.shape, size)], constant_values=AIR)
    n = np.array(padded.shape) // size
    return padded.reshape(n[0], size[0], n[1], size[1], n[2], size[2]).transpose(0, 2, 4, 1, 3, 5)


def field_of(source: np.ndarray, detector: Detector, spectrum: Spectrum) -> Field:
    """Source, detector and spectrum as the kernel reads them."""
    kept, alias = _alias_table(spectrum.fluence / spectrum.fluence.sum())
    (a, b), c = detector.size_mm, np.asarray(source, float) - detector.corner
    foot = np.array([np.clip(c @ detector.u, 0, a), np.clip(c @ detector.v, 0, b)])
    nearest = float(np.linalg.norm(c - foot[0] * detector.u - foot[1] * detector.v))
    return Field(
        _triple(source),
        _triple(detector.corner),
        _triple(detector.u),
        _triple(detector.v),
        _triple(detector.normal),
        (a, b),
        1 / detector.pixel_mm,
        spectrum.energies_kev,
        kept,
        alias,
        nearest,
    )


def _triple(vector: np.ndarray) -> Triple:
    x, y, z = map(float, vector)
    return x, y, z


def _alias_table(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Walker's alias table of probabilities (n,): the share that each column keeps, and who gets the rest."""
    n = len(p)
    kept, alias = p * n, np.arange(n)
    small, large = [i for i in range(n) if kept[i] < 1], [i for i in range(n) if kept[i] >= 1]
    scaled = kept.copy()
    while small and large:
        i, j = small.pop(), large[-1]
        alias[i] = j
        scaled[j] -= 1 - scaled[i]
        if scaled[j] < 1:
            small.append(large.pop())
    for i in small + large:  # full columns, but for rounding
        scaled[i] = 1.0
    return scaled, alias


def require_outside(phantom: Phantom, geometry: Geometry) -> None:
    """Raises XrayError when the source, or one of a grid of places on the detector, is not in air."""
    detector = geometry.detector
    rows, columns = (np.linspace(0, n - 1, min(n, PLACES)).round() for n in detector.shape)
    centres = detector.origin + detector.pixel_mm * (
        columns[None, :, None] * detector.u + rows[:, None, None] * detector.v
    )
    for name, points in (("source", geometry.source[None]), ("detector", centres.reshape(-1, 3))):
        at = np.round(phantom.grid.indices(points)).astype(int)
        held = np.all((at >= 0) & (at < phantom.grid.shape), axis=1)
        if np.any(phantom.index[tuple(at[held].T)] != AIR):
            raise XrayError(f"the {name} is inside the body; move it out, or cut the phantom smaller")


@dataclass(frozen=True)
class ExposureSetup:
    """A phantom in a geometry, and the spectrum of the source.

    Raises XrayError when source or detector are inside the body, or the spectrum leaves the tables.
    """

    phantom: Phantom
    geometry: Geometry
    spectrum: Spectrum

    def __post_init__(self) -> None:
        require_outside(self.phantom, self.geometry)

    @cached_property
    def matter(self) -> Matter:
        """Cross-sections of the phantom's materials."""
        return matter(self.phantom.materials, float(self.spectrum.energies_kev[-1]))

    @cached_property
    def body(self) -> Body:
        """The phantom's voxels."""
        return body_of(self.phantom, self.matter)

    @cached_property
    def photons_per_mas(self) -> float:
        """How many photons start towards the detector, per mAs: N d^2 Omega."""
        N, d = float(self.spectrum.fluence.sum()), self.spectrum.distance_mm
        return N * d**2 * self.geometry.solid_angle()

    def beam(self, detector: Detector, share: np.ndarray | None = None) -> Field:
        """Source and a detector of coarser cells; share: of the energies, when not the spectrum's."""
        spectrum = self.spectrum if share is None else replace(self.spectrum, fluence=share)
        return field_of(self.geometry.source, detector, spectrum)

    def attenuations(self) -> np.ndarray:
        """mu (n_energy, n_material, 2) in 1/mm: total, and of scattering only."""
        E, materials = self.spectrum.energies_kev, self.phantom.materials
        total, absorbed = (
            np.stack([linear_attenuation(m, E, process=process) for m in materials], axis=1)
            for process in ("total", "photoelectric")
        )
        return np.stack([total, total - absorbed], axis=2)
