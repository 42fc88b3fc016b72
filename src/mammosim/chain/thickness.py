"""To which thickness the standard strategy presses: as given, or chosen by how deep the breast hangs.

    t = s d,   d = median(y_ribs) - y_nipple

d: depth of the breast as it was measured, prone, from the ribs right behind it to its nipple, mm; s: the
setting compression.depth_share.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError, MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.volume import LabelMap

GIVEN = "given"
# ASSUME: a woman for whom no thickness is given is pressed to a share of her breast's depth in prone, half by
# default. More than 120 mm is no mammogram: what was taken for a breast is none.
LARGEST_MM = 120.0
# ASSUME: ribs within 30 mm beside, above and below the nipple are behind it; no single node decides their
# median.
BEHIND_MM = 30.0


@dataclass(frozen=True)
class StandardThickness:
    """Of the standard strategy, mm; origin: GIVEN, or how it was chosen."""

    mm: float
    origin: str = GIVEN


def chosen_thickness(
    mesh: TetMesh, nipple: np.ndarray, *, share: float, smallest_mm: float
) -> StandardThickness:
    """A share of the depth of a breast; mesh: as measured, prone, and nipple (3,) mm in its frame.

    Raises MechanicsError as of_depth does, MeshError where no rib is behind it.
    """
    ribs = _behind(mesh.points[mesh.boundary_nodes("posterior")], nipple)
    if len(ribs) == 0:
        raise MeshError(
            f"no chest wall within {BEHIND_MM:g} mm of the nipple's x = {nipple[0]:.0f} and z = "
            f"{nipple[2]:.0f} mm, by which a thickness is chosen; state hers in compression.thickness_mm"
        )
    return of_depth(float(np.median(ribs[:, 1]) - nipple[1]), share=share, smallest_mm=smallest_mm)


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


def depth_in(labels: LabelMap, nipple: np.ndarray) -> float:
    """Depth in mm as labels have it, before there is a mesh; NaN where no rib is labelled behind the nipple.

    nipple (3,) mm, frame of the labels, prone.
    """
    thorax = labels.values == Label.THORAX
    k, i = np.nonzero(thorax.any(axis=1))
    front = np.column_stack([k, thorax.argmax(axis=1)[k, i], i])
    ribs = _behind(labels.grid.points(front.astype(float)), nipple)
    return float(np.median(ribs[:, 1]) - nipple[1]) if len(ribs) else float("nan")


def _behind(points: np.ndarray, nipple: np.ndarray) -> np.ndarray:
    """Those of points (n, 3) mm that are right behind a nipple (3,) mm."""
    found: np.ndarray = points[np.all(np.abs(points - nipple)[:, [0, 2]] < BEHIND_MM, axis=1)]
    return found
