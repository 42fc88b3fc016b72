"""The steps of imaging of equipment in the tables: a tube's heel, a grid, a detector's blur and noise.

The heel: rays that leave the anode at a smaller angle have crossed more of it. The anode lies to the nipple's
side. A ray that leans by phi from the vertical towards the nipple leaves the anode's surface at the angle
a - phi, a that of the ray along the chest wall.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial

from mammosim.core.errors import XrayError
from mammosim.io.tabulated import tabulated
from mammosim.xray.geometry import Geometry
from mammosim.xray.imaging_steps import Blur, ElectronicNoise, Grid, Heel, Structure
from mammosim.xray.response import detector_row
from mammosim.xray.tube import Tube, tube_spectrum

NODES = 8  # of a polynomial in the angle, within 0.1 percent
SMALLEST_DEG = 5.0  # of the tube's model


def heel(geometry: Geometry, tube: tuple[str, str, float, float], *, chest_angle_deg: float = 26.0) -> Heel:
    """Air kerma of each ray over that along the chest wall, without inverse square; v runs to the nipple.

    tube: anode, filter, filter in mm, kvp. chest_angle_deg: between the anode's surface and the ray along the
    chest wall, the anode's angle and the tilt of the tube together.
    Raises XrayError when a ray of the field would graze the anode.
    """
    # ASSUME: anode and tilt make 26 degrees at the chest wall: 240 mm at 650 mm are free.
    d = geometry.detector
    v = (d.origin - geometry.source) @ d.v + d.pixel_mm * np.arange(d.shape[0])
    angles = chest_angle_deg - np.degrees(np.arctan2(v, geometry.source_height_mm))
    if angles.min() < SMALLEST_DEG:
        raise XrayError(
            f"rays at the far edge leave the anode at {angles.min():.1f} degrees, below {SMALLEST_DEG:g}; "
            "make chest_angle_deg larger, or the field shallower"
        )
    curve = _log_kerma(tube, max(float(np.ceil(angles.max())), chest_angle_deg))
    factor = np.exp(curve(angles) - curve(chest_angle_deg))
    return Heel(np.repeat(factor[:, None], d.shape[1], axis=1))


@cache  # the views of an arc share it, and a spectrum takes half a second
def _log_kerma(tube: tuple[str, str, float, float], largest_deg: float) -> Polynomial:
    """ln of the air kerma per mAs of rays that leave the anode at an angle up to the largest, degrees."""
    nodes = np.linspace(SMALLEST_DEG, largest_deg, NODES)
    leaving = [replace(Tube(), anode_angle_deg=float(a)) for a in nodes]
    kerma = [tube_spectrum(*tube, tube=t).kerma_mgy_per_mas for t in leaving]
    return Polynomial.fit(nodes, np.log(kerma), NODES - 1)


def grid_of(name: str) -> Grid:
    """A grid of the table `grids`. Raises XrayError when it has no such grid."""
    rows = {row["grid"]: row for row in tabulated("grids").to_dict("records")}
    if name not in rows:
        raise XrayError(f"unknown grid {name!r}; choose one of: {', '.join(rows)}")
    return Grid(rows[name]["primary"], rows[name]["scatter"])


def blur_of(detector: str) -> Blur:
    """The blur of a detector of the table `image_detectors`."""
    row = detector_row(detector)
    return Blur(row["blur"], row["blur_per_mm"])


def structure_of(detector: str, share: float, pixel_mm: float, seed: int) -> Structure:
    """Gains that differ by `share` between a detector's own pixels, on pixels that are several of them."""
    # ASSUME: the gains of a detector's own pixels are independent.
    return Structure(share * detector_row(detector)["own_pixel_mm"] / pixel_mm, seed)


def electronic_noise_of(detector: str, pixel_mm: float) -> ElectronicNoise:
    """The electronic noise of a detector of the table `image_detectors`, on pixels of pixel_mm.

    Raises XrayError when the table has none for it.
    """
    # ASSUME: a larger pixel is several of the detector's own, whose electronic noises are independent.
    row = detector_row(detector)
    if not row["electronic_noise_electrons"]:
        raise XrayError(f"the electronic noise of {detector!r} is not known; leave this step out")
    kev = row["electronic_noise_electrons"] * row["ev_per_electron"] / 1e3
    return ElectronicNoise(kev * pixel_mm / row["own_pixel_mm"])
