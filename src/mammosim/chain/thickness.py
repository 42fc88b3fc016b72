"""To which thickness the standard strategy presses: as given, or chosen by how deep the breast hangs.

    t = s d,   d = y_ribs - y_nipple

d: depth of the breast as it was measured, prone, from the foremost rib behind it to its nipple, mm; s: the
setting compression.depth_share.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.chain.plates import LEVEL_MM, foremost_rib
from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.volume import LabelMap

GIVEN = "given"
# ASSUME: a woman for whom no thickness is given is pressed to a share of her breast's depth in prone, half by
# default. More than 120 mm is no mammogram: what was taken for a breast is none.
LARGEST_MM = 120.0


@dataclass(frozen=True)
class StandardThickness:
    """Of the standard strategy, mm; origin: GIVEN, or how it was chosen."""

    mm: float
    origin: str = GIVEN


def chosen_thickness(
    mesh: TetMesh, nipple: np.ndarray, *, share: float, half_width_mm: float, smallest_mm: float
) -> StandardThickness:
    """A share of the depth of a breast; mesh: as measured, prone, and nipple (3,) mm in its frame.

    half_width_mm: ribs this far beside the nipple are behind the breast. Raises MechanicsError as of_depth
    does, MeshError where no rib is behind it.
    """
    depth = foremost_rib(mesh, nipple, half_width_mm) - float(nipple[1])
    return of_depth(depth, share=share, smallest_mm=smallest_mm)


def of_depth(depth_mm: float, *, share: float, smallest_mm: float) -> StandardThickness:
    """A share of a depth. Raises MechanicsError where it is less than smallest_mm or more than LARGEST_MM."""
    thickness = share * depth_mm
    how = f"{share:g} of the {depth_mm:.0f} mm from the ribs to the nipple, prone"
    if not smallest_mm <= thickness <= LARGEST_MM:
        raise MechanicsError(
            f"no thickness is given, and {how}, is {thickness:.0f} mm, outside [{smallest_mm:g}, "
            f"{LARGEST_MM:g}]; state hers in compression.thickness_mm, or look at her nipple and labels"
        )
    return StandardThickness(float(thickness), f"chosen: {how}")


def depth_in(labels: LabelMap, nipple: np.ndarray, *, half_width_mm: float) -> float:
    """Depth in mm as labels have it, before there is a mesh; NaN where no rib is labelled behind the nipple.

    nipple (3,) mm, frame of the labels, prone.
    """
    ribs = labels.grid.points(np.argwhere(labels.values == Label.THORAX).astype(float))
    beside, above = np.abs(ribs[:, 0] - nipple[0]), np.abs(ribs[:, 2] - nipple[2])
    behind = ribs[(beside < half_width_mm) & (above < LEVEL_MM), 1]
    return float(behind.min() - nipple[1]) if len(behind) else float("nan")
