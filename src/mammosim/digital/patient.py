"""A virtual patient: the chosen or sampled parameters of her body, each with its unit and its limits."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from mammosim.core.settings import read, require_positive, require_within
from mammosim.mechanics.body import Ligaments

IN_CM = "a length in cm? multiply by 10"


@dataclass(frozen=True)
class Chest:
    """Rib cage: an elliptic cylinder along z round (0, centre_y_mm), on it muscle, fat and skin.

    semi_axis_x_mm, semi_axis_y_mm: of the rib cage's outer face; muscle_mm, fat_mm: thickness of the layers.
    region_back_mm, region_half_height_mm: soft tissue with y and |z| below these moves, the rest is rigid.
    """

    centre_y_mm: float
    semi_axis_x_mm: float
    semi_axis_y_mm: float
    muscle_mm: float
    fat_mm: float
    region_back_mm: float
    region_half_height_mm: float

    def __post_init__(self) -> None:
        _within("semi_axis_x_mm", self.semi_axis_x_mm, 80, 220)
        _within("semi_axis_y_mm", self.semi_axis_y_mm, 60, 180)
        _within("muscle_mm", self.muscle_mm, 3, 25)
        _within("fat_mm", self.fat_mm, 2, 40)
        _within("region_half_height_mm", self.region_half_height_mm, 60, 200)


@dataclass(frozen=True)
class Breast:
    """Left breast: half an ellipsoid on the chest; the right one is right_scale times as large.

    base_radius_mm: in the plane of the chest; projection_mm: from the skin of the chest to the nipple.
    side_mm: |x| of the axis at the chest; lateral_deg, inferior_deg: tilt of the axis away from anterior.
    fold_mm: width over which breast and chest blend; nipple_mm: radius of the nipple.
    """

    base_radius_mm: float
    projection_mm: float
    side_mm: float
    lateral_deg: float
    inferior_deg: float
    fold_mm: float
    nipple_mm: float
    right_scale: float

    def __post_init__(self) -> None:
        _within("base_radius_mm", self.base_radius_mm, 30, 100)
        _within("projection_mm", self.projection_mm, 15, 120)
        _within("lateral_deg", self.lateral_deg, 0, 45)
        _within("fold_mm", self.fold_mm, 1, 40)
        _within("nipple_mm", self.nipple_mm, 2, 10)
        _within("right_scale", self.right_scale, 0.8, 1.25)


@dataclass(frozen=True)
class Gland:
    """fraction: gland per breast volume, skin included; front: share of the gland in the nipple's half.

    cover_mm: fat between gland and skin or muscle; wave_mm: shortest wavelength of the gland's texture.
    """

    fraction: float
    front: float
    cover_mm: float
    wave_mm: float

    def __post_init__(self) -> None:
        _within("fraction", self.fraction, 0.02, 0.45)
        _within("front", self.front, 0.4, 0.8)
        _within("cover_mm", self.cover_mm, 0, 15)
        _within("wave_mm", self.wave_mm, 4, 40)


@dataclass(frozen=True)
class SkinLayer:
    """Thickness of the skin: mean_mm, and how far it varies by region to either side, variation_mm."""

    mean_mm: float
    variation_mm: float

    def __post_init__(self) -> None:
        _within("mean_mm", self.mean_mm, 0.5, 4)
        _within("variation_mm", self.variation_mm, 0, 0.9 * self.mean_mm)


@dataclass(frozen=True)
class SideModuli:
    """Young's moduli of one side, kPa."""

    adipose: float
    glandular: float
    skin: float
    muscle: float

    def __post_init__(self) -> None:
        require_positive(self, "adipose", "glandular", "skin", "muscle")


@dataclass(frozen=True)
class Moduli:
    """Young's moduli of either side."""

    left: SideModuli
    right: SideModuli

    def of(self, side: str) -> SideModuli:
        """Those of `left` or `right`."""
        return {"left": self.left, "right": self.right}[side]


@dataclass(frozen=True)
class VirtualPatient:
    """One virtual patient; seed names the random streams of her gland, skin and lungs.

    moduli_kpa: her own, None where she has those that all have; ligaments: None where she has none.
    """

    chest: Chest
    breast: Breast
    gland: Gland
    skin: SkinLayer
    seed: int
    moduli_kpa: Moduli | None = None
    ligaments: Ligaments | None = None

    @classmethod
    def read(cls, values: Mapping[str, Any], *, at: str = "virtual patient") -> "VirtualPatient":
        """Of nested plain values with the names of the fields; at: what an error calls them."""
        return read(cls, values, at)

    def values(self) -> dict[str, Any]:
        """The nested plain values that `read` takes, without what she does not have."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def _within(name: str, value: float, low: float, high: float) -> None:
    require_within(name, value, low, high, IN_CM)
