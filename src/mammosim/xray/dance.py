"""Mean glandular dose by Dance's factors, and his standard breast to transport photons through.

D = K g c s: incident air kerma K; g for half gland, half fat, by half-value layer and thickness; c for
another glandularity; s for another anode and filter.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.interpolate import RegularGridInterpolator

from mammosim.core.errors import XrayError
from mammosim.core.volume import grid_around
from mammosim.io.tabulated import tabulated
from mammosim.xray.attenuation import material
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom

RADIUS_MM, SHIELD_MM, EVEN_PERCENT = 80.0, 5.0, 50.0
SOURCE_MM, GAP_MM = 600.0, 10.0  # source above the support, detector below it
AIR, SHIELD, FAT, GLAND = range(4)
SECONDARY = "g and s from a secondary source"
UNVERIFIED = "g and s from a secondary source; c unverified, from memory"


@dataclass(frozen=True)
class DanceDose:
    """g, c and s, where they come from, and their product: dose per incident air kerma."""

    g: float
    c: float
    s: float
    status: str

    @property
    def mgy_per_mgy(self) -> float:
        """g c s."""
        return self.g * self.c * self.s


def dance_dose(
    hvl_mm_al: float, thickness_mm: float, *, glandularity_percent: float, combination: str
) -> DanceDose:
    """Factors for a breast of `thickness_mm` and a beam such as 'Mo/Mo' of this half-value layer.

    Raises XrayError outside the tables, or for an unknown combination of anode and filter.
    """
    s = tabulated("dance_s").set_index("combination")["s"]
    if combination not in s.index:
        raise XrayError(f"no s for {combination!r}; choose one of: {', '.join(s.index)}")
    even = tabulated("dance_g")
    g = np.exp(_between(even, np.log(even["g"]), hvl_mm_al, thickness_mm))
    if glandularity_percent == EVEN_PERCENT:
        return DanceDose(g, 1.0, float(s[combination]), SECONDARY)
    # ASSUME: c is linear in glandularity, through 1 at one half.
    typical = tabulated("dance_c")
    slopes = (typical["c"] - 1) / (EVEN_PERCENT - typical["glandularity_percent"])
    per_percent = _between(typical, slopes, hvl_mm_al, thickness_mm)
    c = 1 + per_percent * (EVEN_PERCENT - glandularity_percent)
    return DanceDose(g, c, float(s[combination]), UNVERIFIED)


def _between(table: pd.DataFrame, values: pd.Series, hvl_mm_al: float, thickness_mm: float) -> float:
    """A value per row of a table, linear in half-value layer and log thickness.

    Raises XrayError outside the table.
    """
    grid = table.assign(values=values).pivot(index="hvl_mm_al", columns="thickness_mm", values="values")
    axes = grid.index.to_numpy(), grid.columns.to_numpy()
    for at, axis, what in zip(
        (hvl_mm_al, thickness_mm), axes, ("half-value layer in mm Al", "thickness in mm")
    ):
        if not axis[0] <= at <= axis[-1]:
            raise XrayError(f"{what} = {at:g} is outside Dance's table, {axis[0]:g} to {axis[-1]:g}")
    field = RegularGridInterpolator((axes[0], np.log(axes[1])), grid.to_numpy())
    return float(field((hvl_mm_al, np.log(thickness_mm))))


def standard_breast(
    thickness_mm: float, glandularity_percent: float, *, rng: np.random.Generator, spacing_mm: float = 1.0
) -> Phantom:
    """Dance's breast: half a cylinder of 80 mm radius, a mixture of gland and fat under 5 mm of fat.

    The mixture is of voxels drawn at random, gland with its share of the volume, so that the gland's dose is
    that of its own voxels. x from the chest wall, y lateral, z up from the support.
    Raises XrayError when the shield leaves no room, or is not a whole number of voxels.
    """
    # ASSUME: gland and fat of a standard breast are mixed on the scale of a voxel, far below a free path.
    if not thickness_mm > 2 * SHIELD_MM or not 0 < glandularity_percent <= 100:
        raise XrayError(
            f"no standard breast of {thickness_mm:g} mm and {glandularity_percent:g} % gland: "
            f"it needs more than {2 * SHIELD_MM:g} mm, and gland in (0, 100] %"
        )
    if abs(SHIELD_MM / spacing_mm - round(SHIELD_MM / spacing_mm)) > 1e-9:
        raise XrayError(f"spacing_mm = {spacing_mm:g} does not divide the shield of {SHIELD_MM:g} mm; take 1")
    low, high = np.array([0.0, -RADIUS_MM, 0.0]), np.array([RADIUS_MM, RADIUS_MM, thickness_mm])
    grid = grid_around(low, high, spacing_mm)
    x, y, z = grid.centres().reshape(*grid.shape, 3).transpose(3, 0, 1, 2)
    r, fat, gland = np.hypot(x, y), material("adipose"), material("glandular")
    inner = (r < RADIUS_MM - SHIELD_MM) & (z > SHIELD_MM) & (z < thickness_mm - SHIELD_MM)
    per_volume = np.array([glandularity_percent, 100 - glandularity_percent]) / [
        gland.density_g_cm3, fat.density_g_cm3
    ]  # fmt: skip
    drawn = rng.random(grid.shape) < per_volume[0] / per_volume.sum()
    index = np.where(inner, np.where(drawn, GLAND, FAT), np.where(r < RADIUS_MM, SHIELD, AIR))
    return Phantom(grid, index.astype(np.uint8), (material("air"), fat, fat, gland))


def standard_geometry() -> Geometry:
    """Source above the chest wall, and a detector below the support that sees all of the standard breast."""
    x, y, _ = np.eye(3)
    detector = Detector(np.array([0.5, -99.5, -GAP_MM]), x, y, (200, 100), 1.0)
    return Geometry(np.array([0.0, 0.0, SOURCE_MM]), detector)
