"""The views of a breast pressed along z: one of mammography, or those over the arc of a system."""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.placement import Outline, Room, centred
from mammosim.xray.systems import System, system_named, systems

NAMED = 3  # so many other systems are named at most where one is too small


def mammography_geometry(
    phantom: Phantom,
    *,
    chest_wall_y_mm: float,
    source_to_detector_mm: float = 650.0,
    air_gap_mm: float = 15.0,
    field_mm: tuple[float, float] = (240.0, 300.0),
    pixel_mm: float = 1.0,
) -> Geometry:
    """A craniocaudal view of a breast pressed along z: source above the chest-wall edge, detector below.

    phantom: the pressed breast, its frame mm; source_to_detector_mm, pixel_mm: of the machine.
    Returns source and detector in the frame of the phantom.
    The detector starts at y = chest_wall_y_mm, reaches field_mm[0] to anterior (-y) and field_mm[1] along x,
    centred on the breast's shadow, and lies air_gap_mm below it. Image rows run from the chest wall to the
    nipple. Raises XrayError when the shadow of the breast (tissue with y < chest_wall_y_mm) leaves the field.
    """
    # ASSUME: the focal spot is a point above the chest-wall edge of the detector.
    outline = Outline.of(phantom, chest_wall_y_mm)
    z = outline.bottom_mm - air_gap_mm
    shape = (round(field_mm[0] / pixel_mm), round(field_mm[1] / pixel_mm))

    def view(x: float) -> tuple[Geometry, ...]:
        left = x + (shape[1] - 1) * pixel_mm / 2
        origin = np.array([left, chest_wall_y_mm - pixel_mm / 2, z])
        detector = Detector(origin, np.array([-1.0, 0, 0]), np.array([0, -1.0, 0]), shape, pixel_mm)
        return (Geometry(np.array([x, chest_wall_y_mm, z + source_to_detector_mm]), detector),)

    (geometry,) = centred(view, outline.points, start_mm=outline.middle_mm)
    room = Room.around(outline.points, (geometry,))
    if not room.least_mm >= 0:
        width, depth = geometry.detector.size_mm
        raise XrayError(
            f"the shadow of the breast is {room.needs_mm[0]:.0f} mm wide and {room.needs_mm[1]:.0f} mm deep, "
            f"but the field {width:.0f} x {depth:.0f} mm: enlarge xray.field_mm (width, depth)"
        )
    return geometry


def tomosynthesis_geometries(
    phantom: Phantom, system: System, *, chest_wall_y_mm: float, pixel_mm: float | None = None
) -> tuple[Geometry, ...]:
    """The views of a breast pressed along z, one geometry per angle, in the axes of craniocaudal ones.

    The breast is placed so that its shadow has the same room on both sides over all views.
    pixel_mm: coarser or finer pixels on the same detector. Raises XrayError when the shadow of tissue before
    the chest wall leaves the field of a view: the message names the view, and which systems hold the breast.
    """
    outline = Outline.of(phantom, chest_wall_y_mm)
    # Coarser pixels cover a little less or more: what a system holds does not depend on them.
    room = Room.around(outline.points, _placed(system, outline, chest_wall_y_mm, system.pixel_mm))
    if not room.least_mm >= 0:
        raise XrayError(_too_small(system, room, outline, chest_wall_y_mm))
    return _placed(system, outline, chest_wall_y_mm, pixel_mm or system.pixel_mm)


def _placed(
    system: System, outline: Outline, chest_wall_y_mm: float, pixel_mm: float
) -> tuple[Geometry, ...]:
    """The views of a system with the breast centred, whether it fits or not."""
    z = outline.bottom_mm - system.support_to_detector_mm

    def views(x: float) -> tuple[Geometry, ...]:
        foot = np.array([x, chest_wall_y_mm, z])
        return tuple(_view(system, foot, a, pixel_mm) for a in np.radians(system.angles_deg))

    return centred(views, outline.points, start_mm=outline.middle_mm)


def _too_small(system: System, room: Room, outline: Outline, chest_wall_y_mm: float) -> str:
    """Why a system does not hold the breast, and which do, those with most room first."""
    width, depth = system.size_mm
    angle = system.angles_deg[room.view]
    spare = {
        of.name: Room.around(outline.points, _placed(of, outline, chest_wall_y_mm, of.pixel_mm)).least_mm
        for of in _others(system.name)
    }
    holding = sorted((name for name in spare if spare[name] >= 0), key=lambda name: -spare[name])[:NAMED]
    named = ", ".join(f"{name} ({spare[name]:.0f} mm to spare)" for name in holding)
    advice = "no other system holds her either: press her differently"
    if named:
        advice = f"choose by xray.tomosynthesis.system: {named}"
    return (
        f"the shadow of the breast leaves the detector of {system.name} in view {room.view + 1} of "
        f"{system.views} at {angle:.1f} degrees: all views together cover {room.needs_mm[0]:.0f} x "
        f"{room.needs_mm[1]:.0f} mm, the detector {width:.0f} x {depth:.0f} mm; {advice}"
    )


def _others(name: str) -> Iterator[System]:
    """The complete systems with an arc, but for one."""
    for other in systems():
        with suppress(XrayError):
            of = system_named(other)
            if of.arc_deg > 0 and other != name:
                yield of


def _view(system: System, foot: np.ndarray, a: float, pixel_mm: float) -> Geometry:
    """Source at the angle a; the middle of the detector's chest edge is at foot (3,)."""
    share = system.detector_turn_deg / system.arc_deg if system.arc_deg else 0.0
    b = a * share
    R, pivot = system.source_to_pivot_mm, system.source_to_detector_mm - system.source_to_pivot_mm
    source = foot + np.array([R * np.sin(a), 0.0, pivot + R * np.cos(a)])
    u, v = np.array([-np.cos(b), 0.0, np.sin(b)]), np.array([0.0, -1.0, 0.0])
    width, depth = system.size_mm
    shape = (round(depth / pixel_mm), round(width / pixel_mm))
    origin = foot - (shape[1] - 1) / 2 * pixel_mm * u + pixel_mm / 2 * v
    return Geometry(source, Detector(origin, u, v, shape, pixel_mm))
