"""Spectra of mammographic X-ray tubes, by spekpy (Poludniowski et al. 2021, Med Phys 48:3630)."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.units import MM_PER_CM
from mammosim.io.tabulated import tabulated
from mammosim.xray.spectrum import Spectrum

KVP_LIMITS = (20.0, 40.0)
LOWEST_ENERGY_KEV = 4.0  # the table of air energy absorption starts at 3.75 keV


@dataclass(frozen=True)
class Tube:
    """What stands in the beam's way inside the tube, and the bins of its spectrum.

    anode_angle_deg: of the target's surface; window_mm_be: beryllium; bin_kev: width of a bin.
    Raises XrayError for a value that no tube has.
    """

    anode_angle_deg: float = 16.0
    window_mm_be: float = 1.0
    bin_kev: float = 0.5

    def __post_init__(self) -> None:
        if not 5 <= self.anode_angle_deg <= 30:
            raise XrayError(f"anode_angle_deg = {self.anode_angle_deg} is outside 5 to 30 degrees")
        if not 0.3 <= self.window_mm_be <= 3:
            raise XrayError(
                f"window_mm_be = {self.window_mm_be} is outside 0.3 to 3 mm; tubes have about 1 mm"
            )
        if not 0.1 <= self.bin_kev <= 1:
            raise XrayError(f"bin_kev = {self.bin_kev} is outside 0.1 to 1 keV")


def tube_spectrum(
    anode: str,
    filter: str,
    filter_mm: float,
    kvp: float,
    *,
    distance_mm: float = 1000.0,
    tube: Tube | None = None,
) -> Spectrum:
    """Spectrum of a mammographic tube by spekpy (Poludniowski et al. 2021): ("W", "Rh", 0.05, 28.0).

    anode and filter: symbols of elements; filter_mm: its thickness; kvp: peak voltage; tube: what is in it.
    Returns photons per mm2 and mAs behind window and filter, in vacuum, at `distance_mm`.
    Raises XrayError for a target and filter that no tube has, an unlikely thickness, or kvp outside 20 to 40.
    """
    require_tube(anode, filter, filter_mm, kvp)
    tube = tube or Tube()
    # ASSUME: the spectrum is spekpy's model "kqp", the same in every direction of the field (no heel effect).
    import spekpy  # here, since it takes half a second that most stages need not

    model = spekpy.Spek(
        kvp=kvp, th=tube.anode_angle_deg, targ=anode, mas=1, z=distance_mm / MM_PER_CM, dk=tube.bin_kev,
        physics="kqp", mu_data_source="nist",
    )  # fmt: skip
    model.filter("Be", tube.window_mm_be).filter(filter, filter_mm)
    energies, per_cm2 = model.get_spectrum(diff=False)
    # ASSUME: no photon below 4 keV leaves the tube (at most 1e-7 of them would, through the usual filters).
    kept = (energies >= LOWEST_ENERGY_KEV) & (per_cm2 > 0)
    name = f"{anode}/{filter} {filter_mm:g} mm {kvp:g} kVp"
    return Spectrum(np.array(energies[kept]), np.array(per_cm2[kept]) / MM_PER_CM**2, distance_mm, name)


def require_tube(anode: str, filter: str, filter_mm: float, kvp: float) -> None:
    """Raises XrayError for a tube voltage, target, filter or thickness outside those of mammography."""
    low, high = KVP_LIMITS
    if not low <= kvp <= high:
        raise XrayError(
            f"kvp = {kvp:g} is outside {low:g} to {high:g} kV, the range of mammography; beams of computed "
            "tomography and radiography need another tube and other tables"
        )
    table = tabulated("tube_combinations").set_index(["anode", "filter"])
    if (anode, filter) not in table.index:
        known = ", ".join("/".join(pair) for pair in table.index)
        raise XrayError(f"no mammographic tube has {anode}/{filter}; choose one of: {known}")
    limits = table.loc[(anode, filter)]
    if not limits.smallest_mm <= filter_mm <= limits.largest_mm:
        raise XrayError(
            f"filter_mm = {filter_mm:g} is outside {limits.smallest_mm:g} to {limits.largest_mm:g} mm for "
            f"{anode}/{filter}; usual is {limits.usual_mm:g} mm"
        )
