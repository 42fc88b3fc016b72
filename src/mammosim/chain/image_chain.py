"""The steps of imaging: each configured name becomes an object here; a step that is not named is absent."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import require_positive, require_within
from mammosim.xray.equipment import blur_of, electronic_noise_of, grid_of, heel, structure_of
from mammosim.xray.geometry import Geometry
from mammosim.xray.imaging_steps import FocalSpot, ImagingStep, QuantumNoise
from mammosim.xray.response import Response, response_of


@dataclass(frozen=True)
class Tube:
    """An X-ray tube: target, filter and its thickness in um, peak voltage in kV.

    Raises ConfigurationError for a thickness or a voltage that is not above 0.
    """

    anode: str
    filter: str
    filter_um: float
    peak_kv: float

    def __post_init__(self) -> None:
        require_positive(self, "filter_um", "peak_kv")

    @property
    def beam(self) -> tuple[str, str, float, float]:
        """Anode, filter, its thickness in mm, and kV: what xray.tube.tube_spectrum takes."""
        return self.anode, self.filter, self.filter_um / 1e3, self.peak_kv


@dataclass(frozen=True)
class Equipment:
    """The parts of a mammograph that act on an image.

    detector: of the table `image_detectors`; grid: of the table of grids; focal_spot_mm: its full width at
    half maximum; structure_percent: of the gain of one of the detector's own pixels, standard deviation.
    Raises ConfigurationError for a size below 0.
    """

    tube: Tube
    detector: str
    focal_spot_mm: float
    grid: str
    structure_percent: float

    def __post_init__(self) -> None:
        require_within("focal_spot_mm", self.focal_spot_mm, 0, 5, "usual is 0.1 to 0.3")
        require_within("structure_percent", self.structure_percent, 0, 100)


@dataclass(frozen=True)
class Acquisition:
    """How an image is taken: its geometry, and the height in mm of the breast's middle over the detector.

    seed: names the fixed structure of the detector.
    """

    geometry: Geometry
    middle_mm: float
    equipment: Equipment
    seed: int = 0

    @property
    def magnification(self) -> float:
        """Of the middle of the breast."""
        far = self.geometry.source_height_mm
        return far / (far - self.middle_mm)

    def of_image(self, name: str) -> ImagingStep:
        """The step of STEPS with this name."""
        return STEPS[name](self)


# What acts on an image once primary and scatter are known.
STEPS: Mapping[str, Callable[[Acquisition], ImagingStep]] = {
    "heel": lambda at: heel(at.geometry, at.equipment.tube.beam),
    "focal_spot": lambda at: FocalSpot(at.equipment.focal_spot_mm, at.magnification),
    "grid": lambda at: grid_of(at.equipment.grid),
    "quantum_noise": lambda at: QuantumNoise(),
    "blur": lambda at: blur_of(at.equipment.detector),
    "structure": lambda at: structure_of(
        at.equipment.detector,
        at.equipment.structure_percent / 100,
        at.geometry.detector.pixel_mm,
        at.seed,
    ),
    "electronic_noise": lambda at: electronic_noise_of(at.equipment.detector, at.geometry.detector.pixel_mm),
}
# What is decided before: scatter by the stage that computes it, the response where images are computed.
BEFORE = ("scatter", "response")


@dataclass(frozen=True)
class ImageChain:
    """The steps of an image, and the response of its detector, None where it absorbs every photon."""

    steps: tuple[ImagingStep, ...]
    response: Response | None

    @classmethod
    def named(cls, names: Sequence[str], acquisition: Acquisition) -> "ImageChain":
        """The chain of these steps. Raises ConfigurationError for a name that means none."""
        unknown = [name for name in names if name not in STEPS and name not in BEFORE]
        if unknown:
            known = ", ".join((*BEFORE, *STEPS))
            raise ConfigurationError(f"no effect {unknown[0]!r} of an image; choose among: {known}")
        return cls(
            tuple(acquisition.of_image(name) for name in names if name in STEPS),
            response_of(acquisition.equipment.detector) if "response" in names else None,
        )
