"""The mammography case of AAPM report 195 (Sechopoulos et al. 2015, Med Phys 42:5679), to verify against.

x from the chest wall to the nipple, y lateral, z up to the tube; origin at mid-thickness on the chest wall.
"""

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import grid_around
from mammosim.io.tabulated import tabulated
from mammosim.xray.attenuation import material, mixture
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.spectrum import Spectrum, monoenergetic

AIR, TISSUE, SKIN, PLATE, BODY = range(5)
BEAMS = ("16.8 keV", "Mo/Mo 30 kVp")
PLANE_MM, ARM_MM = -40.0, 660.0
REGION_MM = (20.0, 20.0, 10.0)


def breast_of_report(spacing_mm: float = 1.0) -> Phantom:
    """Half a cylinder of tissue under skin, between two plates, at a body of water, in air.

    spacing_mm: 1 or 2, so that skin and plates have their thickness of 2 mm.
    Raises XrayError for another spacing.
    """
    if spacing_mm not in (1.0, 2.0):
        raise XrayError(f"spacing_mm = {spacing_mm} does not resolve skin and plates of 2 mm; take 1 or 2")
    # An odd number of mm below and above, so that voxels of 2 mm meet z = 23, 25 and 27, too.
    grid = grid_around(np.array([-170.0, -150.0, -151.0]), np.array([140.0, 150.0, 151.0]), spacing_mm)
    nz, ny, nx = grid.shape
    x = grid.origin[0] + grid.spacing[0] * np.arange(nx)[None, None, :]
    y = grid.origin[1] + grid.spacing[1] * np.arange(ny)[None, :, None]
    z = np.abs(grid.origin[2] + grid.spacing[2] * np.arange(nz)[:, None, None])
    r2 = x**2 + y**2
    index = np.full(grid.shape, AIR, np.uint8)
    index[np.broadcast_to((x < 0) & (z < 150), grid.shape)] = BODY
    index[(x > 0) & (r2 < 100**2) & (z < 25)] = SKIN
    index[(x > 0) & (r2 < 98**2) & (z < 23)] = TISSUE
    index[(x > 0) & (np.abs(y) < 130) & (z > 25) & (z < 27)] = PLATE
    parts = ((material("adipose"), 0.8), (material("glandular"), 0.2))
    tissue = mixture("20 % glandular", parts, density_g_cm3=0.952)
    return Phantom(
        grid, index, (material("air"), tissue, material("skin"), material("pmma"), material("water"))
    )


def geometry_of_report(angle_deg: float = 0.0) -> Geometry:
    """Point source 660 mm from the scoring plane, collimated to its 140 x 260 mm; pixels of 1 mm.

    angle_deg: by which the source turns towards +y about the plane's chest-wall edge, as in tomosynthesis.
    """
    x, y, z = np.eye(3)
    a = np.radians(angle_deg)
    pivot = np.array([0.0, 0.0, PLANE_MM])
    source = pivot + ARM_MM * (np.sin(a) * y + np.cos(a) * z)
    return Geometry(source, Detector(np.array([0.5, -129.5, PLANE_MM]), x, y, (260, 140), 1.0))


def beam_of_report(name: str) -> Spectrum:
    """One of BEAMS, in vacuum. Raises XrayError for another name."""
    if name not in BEAMS:
        raise XrayError(f"unknown beam {name!r}; choose one of: {', '.join(BEAMS)}")
    if name == "16.8 keV":
        return monoenergetic(16.8)
    table = tabulated("report195_mo_mo_30kvp")
    return Spectrum(table["energy_kev"].to_numpy(), table["probability"].to_numpy(), name=name)


def regions_of_report() -> np.ndarray:
    """Lower and upper corners (7, 2, 3) of the regions 1 to 7."""
    table = tabulated("report195_case3")
    centres = table.loc[table["beam"] == BEAMS[0], ["x_mm", "y_mm", "z_mm"]].dropna().to_numpy()
    half = np.array(REGION_MM) / 2
    return np.stack([centres - half, centres + half], axis=1)
