"""A few boxes around all that is not air, so that photons cross the air between them in one exact step."""

import numpy as np

WORTHWHILE = 0.1  # a split must save this share of the boxes' volume
MOST_BOXES = 6


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
