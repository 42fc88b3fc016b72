"""What a person adds to the raw images: clicks on markers and nipples, and strokes of paint in tissues."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError, SegmentationError
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.settings import require_positive
from mammosim.core.volume import LabelMap
from mammosim.digital.body import Body
from mammosim.digital.signal import Scan, marker_centres

PAINTED = (Label.AIR, Label.ADIPOSE, Label.GLANDULAR, Label.SKIN, Label.MUSCLE, Label.THORAX)
TRIES = 12  # directions tried before a stroke ends
WANDER_DEG = 25.0  # standard deviation of the turn of a stroke per step


def clicked(body: Body, *, scan: Scan, error_mm: float, stream: tuple[str | int, ...]) -> Fiducials:
    """Markers and nipples as clicked in the image, scanner frame: centres of the balls, tips of the nipples.

    error_mm: standard deviation of each coordinate.
    """
    # ASSUME: a person clicks markers and nipples with a normal error, independent in every coordinate.
    listed = body.fiducials()
    points = listed.points.copy()
    points[[kind != "nipple" for kind in listed.kinds]] = marker_centres(body, scan)
    error = generator(*stream, "clicks").normal(scale=error_mm, size=points.shape)
    return Fiducials(listed.names, listed.kinds, points + error)


@dataclass(frozen=True)
class Painting:
    """What a person paints on the slices nearest to z_mm: so many strokes of each tissue that is seen there.

    steps: how many voxels a stroke is long at most.
    """

    z_mm: tuple[float, ...]
    per_tissue: int
    steps: int

    def __post_init__(self) -> None:
        require_positive(self, "per_tissue", "steps")
        if not self.z_mm:
            raise ConfigurationError("z_mm names no slice; name some that cut the breasts")


def strokes(labels: LabelMap, painting: Painting, *, stream: tuple[str | int, ...]) -> pd.DataFrame:
    """Points (x_mm, y_mm, z_mm, tissue) of painted strokes: lines inside one tissue.

    Raises SegmentationError when a tissue is on none of the slices.
    """
    # ASSUME: whoever paints the training strokes recognises every tissue and stays inside it.
    rng = generator(*stream, "strokes")
    painted = []
    for z in painting.z_mm:
        k = _slice_at(labels, z)
        for label in PAINTED:
            for _ in range(painting.per_tissue):
                pixels = _stroke(labels.values[k] == label, painting.steps, rng)
                voxels = np.column_stack([np.full(len(pixels), k), pixels]).astype(float)
                painted.append(_rows(labels.grid.points(voxels), label))
    table = pd.concat(painted, ignore_index=True)
    if missing := {label.tissue for label in PAINTED} - set(table.tissue):
        raise SegmentationError(
            f"the slices at z = {list(painting.z_mm)} mm show no {', '.join(sorted(missing))}; "
            "choose slices through the breasts"
        )
    return table


def _slice_at(labels: LabelMap, z: float) -> int:
    nz, ny, nx = labels.grid.shape
    x, y, _ = labels.grid.points(np.array([[0, (ny - 1) / 2, (nx - 1) / 2]]))[0]
    k = round(float(labels.grid.indices(np.array([[x, y, z]]))[0, 0]))
    return int(np.clip(k, 0, nz - 1))


def _stroke(seen: np.ndarray, steps: int, rng: np.random.Generator) -> np.ndarray:
    """Pixels (n, 2) of a line that starts anywhere in the mask (ny, nx) and ends where it would leave it."""
    inside = np.argwhere(seen)
    if not len(inside):
        return np.empty((0, 2), int)
    at = inside[rng.integers(len(inside))].astype(float)
    heading, line = rng.uniform(0, 2 * np.pi), [at.copy()]
    while len(line) < steps:
        turns = np.radians(WANDER_DEG) * rng.normal(size=TRIES) * np.arange(1, TRIES + 1)
        ahead = at + np.column_stack([np.sin(heading + turns), np.cos(heading + turns)])
        free = np.flatnonzero(_holds(seen, ahead))
        if not len(free):
            break
        at, heading = ahead[free[0]], heading + turns[free[0]]
        line.append(at.copy())
    return np.unique(np.round(line).astype(int), axis=0)


def _holds(seen: np.ndarray, points: np.ndarray) -> np.ndarray:
    pixels = np.round(points).astype(int)
    within = np.all((pixels >= 0) & (pixels < seen.shape), axis=1)
    return within & seen[tuple(np.where(within[:, None], pixels, 0).T)]


def _rows(points: np.ndarray, label: Label) -> pd.DataFrame:
    x, y, z = points.T
    return pd.DataFrame({"x_mm": x, "y_mm": y, "z_mm": z, "tissue": label.tissue})
