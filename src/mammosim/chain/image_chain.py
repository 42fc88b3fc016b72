"""The image chain of a study: what its configuration names becomes an effect here; what not is absent."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mammosim.core.errors import ConfigurationError
from mammosim.xray.equipment import blur_of, electronic_noise_of, grid_of, heel, structure_of
from mammosim.xray.geometry import Geometry
from mammosim.xray.imaging_steps import FocalSpot, ImagingStep, QuantumNoise
from mammosim.xray.response import Response, response_of


@dataclass(frozen=True)
class Acquisition:
    """How an image is taken: its geometry, and the height in mm of the breast's middle over the detector.

    settings: detector, focal_spot_mm, grid, structure_percent, seed, and of the tube anode, filter,
    filter_um, peak_kv.
    """

    geometry: Geometry
    middle_mm: float
    settings: Mapping[str, Any]

    @property
    def magnification(self) -> float:
        """Of the middle of the breast."""
        far = self.geometry.source_height_mm
        return far / (far - self.middle_mm)

    def of_image(self, name: str) -> ImagingStep:
        """The effect of EFFECTS with this name."""
        return EFFECTS[name](self)


def _heel(taken: Acquisition) -> ImagingStep:
    tube = taken.settings
    return heel(taken.geometry, (tube["anode"], tube["filter"], tube["filter_um"] / 1e3, tube["peak_kv"]))


# What acts on an image once primary and scatter are known.
EFFECTS: Mapping[str, Callable[[Acquisition], ImagingStep]] = {
    "heel": _heel,
    "focal_spot": lambda taken: FocalSpot(taken.settings["focal_spot_mm"], taken.magnification),
    "grid": lambda taken: grid_of(taken.settings["grid"]),
    "quantum_noise": lambda taken: QuantumNoise(),
    "blur": lambda taken: blur_of(taken.settings["detector"]),
    "structure": lambda taken: structure_of(
        taken.settings["detector"],
        taken.settings["structure_percent"] / 100,
        taken.geometry.detector.pixel_mm,
        taken.settings["seed"],
    ),
    "electronic_noise": lambda taken: electronic_noise_of(
        taken.settings["detector"], taken.geometry.detector.pixel_mm
    ),
}
# What is decided before: scatter by the rule that computes it, the response where images are computed.
BEFORE = ("scatter", "response")


@dataclass(frozen=True)
class ImageChain:
    """The effects of an image, and the response of its detector, None where it absorbs every photon."""

    effects: tuple[ImagingStep, ...]
    response: Response | None

    @classmethod
    def named(cls, names: Sequence[str], taken: Acquisition) -> "ImageChain":
        """The chain of these effects. Raises ConfigurationError for a name that means none."""
        unknown = [name for name in names if name not in EFFECTS and name not in BEFORE]
        if unknown:
            known = ", ".join((*BEFORE, *EFFECTS))
            raise ConfigurationError(f"no effect {unknown[0]!r} of an image; choose among: {known}")
        return cls(
            tuple(taken.of_image(name) for name in names if name in EFFECTS),
            response_of(taken.settings["detector"]) if "response" in names else None,
        )
