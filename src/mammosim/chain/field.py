"""Whether the detectors hold the shadow of a pressed breast: known before photons are spent on it."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.mammogram import xray_phantom
from mammosim.chain.view import craniocaudal
from mammosim.core.errors import MissingResult, XrayError
from mammosim.core.volume import LabelMap
from mammosim.xray.geometry import Geometry
from mammosim.xray.placement import Outline, Room
from mammosim.xray.systems import system_named
from mammosim.xray.views import tomosynthesis_geometries

HELD = "held"
MAMMOGRAM, TOMOSYNTHESIS = "mammogram", "tomosynthesis"
NUMBERS = ("room_mm", "width_mm", "depth_mm", "shadow_width_mm", "shadow_depth_mm")


def field_rows(
    labels: LabelMap, *, chest_y_mm: float, geometry: Mapping[str, Any], scan: Mapping[str, Any]
) -> pd.DataFrame:
    """A row for mammography and one for tomosynthesis: columns view, system, NUMBERS, outcome.

    labels: the pressed breast; geometry: settings of chain.view.craniocaudal; scan: system and pixel_mm.
    room_mm: least distance of the shadow, over all views, from the sides and the front of the detector;
    width_mm, depth_mm: of the detector; shadow_*: what the shadows of all views cover; NaN where the breast
    does not fit, and outcome says why; else it is HELD.
    """
    phantom, name = xray_phantom(labels), str(scan["system"])
    points = Outline.of(phantom, chest_y_mm).points

    def one() -> Sequence[Geometry]:
        return (craniocaudal(labels, chest_y_mm=chest_y_mm, **geometry),)

    def many() -> Sequence[Geometry]:
        return tomosynthesis_geometries(
            phantom, system_named(name), chest_wall_y_mm=chest_y_mm, pixel_mm=scan["pixel_mm"]
        )

    views = {MAMMOGRAM: ("mammography", one), TOMOSYNTHESIS: (name, many)}
    rows = [{"view": v, "system": s, **_measured(points, made)} for v, (s, made) in views.items()]
    return pd.DataFrame(rows)


def _measured(points: np.ndarray, views: Callable[[], Sequence[Geometry]]) -> dict[str, float | str]:
    """NUMBERS and the outcome of the views."""
    try:
        found = views()
    except XrayError as error:
        return dict.fromkeys(NUMBERS, np.nan) | {"outcome": str(error)}
    room = Room.around(points, found)
    numbers = (room.least_mm, *found[0].detector.size_mm, *room.needs_mm)
    return dict(zip(NUMBERS, numbers, strict=True)) | {"outcome": HELD}


def require_held(rows: pd.DataFrame, view: str) -> None:
    """Raise MissingResult, with the reason, when the breast does not fit the detector of a view."""
    row = rows[rows["view"] == view].iloc[0]
    if row.outcome != HELD:
        names = (row[name] for name in ("volunteer", "side", "strategy", "moduli") if name in row)
        raise MissingResult(f"{view} {' '.join(names)}: {row.outcome}")
