"""Mammography and tomosynthesis systems: where the source stands on its arc, and how the detector turns.

At the angle a the source is R (sin a, 0, cos a) from a pivot over the chest edge of the detector, whose
normal is (sin b, 0, cos b) with b = a turn/arc: b = 0 for a detector at rest.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import XrayError
from mammosim.io.tabulated import tabulated


@dataclass(frozen=True)
class System:
    """A system of the table `imaging_systems`; views over an arc, angles in degrees, lengths in mm.

    Raises XrayError when views and arc contradict each other, or the pivot is not below the source.
    """

    name: str
    views: int
    arc_deg: float
    source_to_detector_mm: float
    source_to_pivot_mm: float
    support_to_detector_mm: float
    pixel_mm: float
    depth_pixels: int
    width_pixels: int
    detector_turn_deg: float
    focal_spot_mm: float
    motion_deg: float

    def __post_init__(self) -> None:
        if self.views < 1 or not 0 <= self.arc_deg < 90 or (self.views == 1) != (self.arc_deg == 0):
            raise XrayError(
                f"{self.views} views over {self.arc_deg:g} degrees: one view has no arc, several share one"
            )
        if not 0 < self.source_to_pivot_mm <= self.source_to_detector_mm:
            raise XrayError(
                f"source_to_pivot_mm = {self.source_to_pivot_mm:g} must be at most source_to_detector_mm = "
                f"{self.source_to_detector_mm:g}, or the pivot lies behind the detector"
            )
        if not 0 <= self.detector_turn_deg <= self.arc_deg:
            raise XrayError(
                f"the detector turns by {self.detector_turn_deg:g}, the source by {self.arc_deg:g} degrees"
            )

    @property
    def size_mm(self) -> tuple[float, float]:
        """Width and depth of the detector: along the chest wall, and from there to the nipple."""
        return self.pixel_mm * self.width_pixels, self.pixel_mm * self.depth_pixels

    @property
    def angles_deg(self) -> np.ndarray:
        """Of the source (views,), from the detector's normal at rest."""
        return np.linspace(-self.arc_deg / 2, self.arc_deg / 2, self.views)

    def magnification(self, height_mm: float) -> float:
        """Of what lies height_mm above the detector, seen from straight above: SDD/(SDD - height)."""
        return self.source_to_detector_mm / (self.source_to_detector_mm - height_mm)


def systems() -> tuple[str, ...]:
    """Names of the systems in the table."""
    return tuple(tabulated("imaging_systems")["system"])


def system_named(name: str) -> System:
    """A system of the table. Raises XrayError when it has no such system, or lacks something of it."""
    return system_of(tabulated("imaging_systems"), name)


def system_of(table: pd.DataFrame, name: str) -> System:
    """A system of a table with the column `system` and those of System. Raises XrayError as system_named."""
    known = {row.pop("system"): row for row in table.to_dict("records")}
    if name not in known:
        raise XrayError(f"unknown system {name!r}; choose one of: {', '.join(known)}")
    names = [each.name for each in fields(System) if each.name != "name"]
    lacking = [each for each in names if pd.isna(known[name].get(each, np.nan))]
    if lacking:
        raise XrayError(
            f"the system {name!r} lacks {', '.join(lacking)}; complete its row of the table imaging_systems, "
            f"or choose another one: {', '.join(other for other in known if other != name)}"
        )
    # One gap in a column of integers makes all of them floats.
    kinds = {each.name: int if each.type is int else float for each in fields(System)}
    values: dict[str, Any] = {each: kinds[each](known[name][each]) for each in names}
    return System(name, **values)
