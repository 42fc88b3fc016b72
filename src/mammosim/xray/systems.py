"""Mammography and tomosynthesis systems: where the source stands on its arc, and how the detector turns.

At the angle a the source is R (sin a, 0, cos a) from a pivot over the chest edge of the detector, whose
normal is (sin b, 0, cos b) with b = a turn/arc: b = 0 for a detector at rest.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.io.tabulated import tabulated
from mammosim.xray.geometry import Detector, Geometry, breast_surface, require_in_field
from mammosim.xray.phantom import Phantom


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
    """A system of the table. Raises XrayError when it has no such system."""
    known = {row.pop("system"): row for row in tabulated("imaging_systems").to_dict("records")}
    if name not in known:
        raise XrayError(f"unknown system {name!r}; choose one of: {', '.join(known)}")
    return System(name, **known[name])


def tomosynthesis_geometries(
    phantom: Phantom,
    system: System,
    *,
    chest_wall_y_mm: float,
    pixel_mm: float | None = None,
    nipple: np.ndarray | None = None,
) -> tuple[Geometry, ...]:
    """The views of a breast pressed along z, one geometry per angle, in the axes of craniocaudal ones.

    pixel_mm: coarser or finer pixels on the same detector; nipple: (3,) mm, looked after by its name.
    Raises XrayError when the shadow of the nipple, or of tissue before the chest wall, leaves the field of a
    view: the message names which, and the view.
    """
    tops, bottom = breast_surface(phantom, chest_wall_y_mm)
    middle = (tops[:, 0].min() + tops[:, 0].max()) / 2
    foot = np.array([middle, chest_wall_y_mm, bottom - system.support_to_detector_mm])
    watched = (
        {"breast": tops} if nipple is None else {"nipple": np.asarray(nipple, float)[None], "breast": tops}
    )
    found = []
    for n, angle in enumerate(system.angles_deg):
        geometry = _view(system, foot, np.radians(angle), pixel_mm or system.pixel_mm)
        for name, points in watched.items():
            of = f"{name} in view {n + 1} of {system.views} at {angle:.1f} degrees"
            require_in_field(geometry, points, of=of)
        found.append(geometry)
    return tuple(found)


def _view(system: System, foot: np.ndarray, a: float, pixel_mm: float) -> Geometry:
    """Source at the angle a; the middle of the detector's chest edge is at foot (3,)."""
    share = system.detector_turn_deg / system.arc_deg if system.arc_deg else 0.0
    b = a * share
    R, pivot = system.source_to_pivot_mm, system.source_to_detector_mm - system.source_to_pivot_mm
    source = foot + np.array([R * np.sin(a), 0.0, pivot + R * np.cos(a)])
    u, v = np.array([-np.cos(b), 0.0, np.sin(b)]), np.array([0.0, -1.0, 0.0])
    depth, width = (system.pixel_mm * n for n in (system.depth_pixels, system.width_pixels))
    shape = (round(depth / pixel_mm), round(width / pixel_mm))
    origin = foot - (shape[1] - 1) / 2 * pixel_mm * u + pixel_mm / 2 * v
    return Geometry(source, Detector(origin, u, v, shape, pixel_mm))
