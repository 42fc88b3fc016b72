"""The plates of the hard cases: where they stand, how they are turned, to what they press, in how many steps.

They lie across y, their chest edge faces the chest wall, before they are turned about their centre.
"""

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Count, Limits, OneOf, Settings, Triple
from mammosim.mechanics.paddles import Flexible, Friction, Paddle, Plates, Rigid, Tilting
from mammosim.mechanics.stage import Control, Force, PressSettings, Thickness
from mammosim.study.hard_cases.bodies import Length

# The first axis of plates points outward along z, the last, from support to paddle, along y.
_PLATE_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T
_HALF_HEIGHT_MM = 15.0
_RIGID = Rigid()


@dataclass(frozen=True)
class PressSetup:
    """Plates, to what they press, and how that is solved."""

    plates: Plates
    control: Control
    settings: PressSettings = field(default_factory=PressSettings)

    def moved(self, R: np.ndarray, mm: np.ndarray) -> "PressSetup":
        """The plates carried from x to R x + mm; R (3, 3) orthogonal, mm (3,)."""
        plates = replace(self.plates, centre=R @ self.plates.centre + mm, axes=R @ self.plates.axes)
        return replace(self, plates=plates)

    def scaled(self, s: float, c: float, penalty: float) -> "PressSetup":
        """Lengths times s, stresses times c; penalty: of the contact before, kPa/mm.

        Raises ConfigurationError for a paddle that bends.
        """
        plates, friction, how = self.plates, self.plates.friction, self.settings
        return PressSetup(
            replace(
                plates,
                centre=s * plates.centre,
                half_sizes=s * plates.half_sizes,
                edge_radius_mm=s * plates.edge_radius_mm,
                paddle=_scaled_paddle(plates.paddle, c * s**3),
                friction=friction and replace(friction, slip_mm=s * friction.slip_mm),
            ),
            _scaled_control(self.control, s, c),
            replace(
                how,
                smallest_step_mm=s * how.smallest_step_mm,
                penetration_mm=s * how.penetration_mm,
                penalty_kpa_per_mm=c / s * penalty,
            ),
        )


def _scaled_paddle(paddle: Paddle, moment: float) -> Paddle:
    if isinstance(paddle, Tilting):
        return replace(paddle, stiffness_n_mm_per_rad=moment * paddle.stiffness_n_mm_per_rad)
    if paddle.unknowns:
        raise ConfigurationError("a paddle that bends is not scaled; use another invariance test")
    return paddle


def _scaled_control(control: Control, s: float, c: float) -> Control:
    if isinstance(control, Force):
        return replace(control, newton=c * s**2 * control.newton, smallest_mm=s * control.smallest_mm)
    return Thickness(s * control.mm)


@dataclass(frozen=True)
class PressValues(Settings):
    """Plates that begin at z = chest_edge_mm, and to what they press: one of thickness_mm and force_n.

    offset_mm: of their centre from x = y = 0; turned_degrees: about x, then y, then z through their centre.
    """

    edge_radius_mm: Length
    chest_edge_mm: Annotated[float, Limits(at_least=-500, at_most=1000)]
    thickness_mm: Length | None = None
    force_n: Annotated[float, Limits(above=0, at_most=1000)] | None = None
    half_width_mm: Length = 80.0
    half_depth_mm: Length = 60.0
    offset_mm: tuple[float, float] = (0.0, 0.0)
    turned_degrees: Triple = (0.0, 0.0, 0.0)
    friction: Annotated[float, Limits(at_least=0, at_most=2)] | None = None
    paddle: Annotated[
        Rigid | Tilting | Flexible, OneOf({"rigid": Rigid, "tilting": Tilting, "flexible": Flexible})
    ] = _RIGID
    steps: Count = 8

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.thickness_mm is None) == (self.force_n is None):
            raise ConfigurationError("plates press to one of thickness_mm and force_n; give exactly one")

    def setup(self) -> PressSetup:
        """Where they stand. Raises MechanicsError for plates that cannot be."""
        axes = Rotation.from_euler("xyz", self.turned_degrees, degrees=True).as_matrix() @ _PLATE_AXES
        plates = Plates(
            np.array([*self.offset_mm, self.chest_edge_mm + self.half_depth_mm]),
            axes,
            np.array([self.half_depth_mm, self.half_width_mm, _HALF_HEIGHT_MM]),
            self.edge_radius_mm,
            self.paddle,
            None if self.friction is None else Friction(self.friction),
        )
        control = Force(self.force_n) if self.force_n is not None else Thickness(self.thickness_mm or 0.0)
        return PressSetup(plates, control, PressSettings(steps=self.steps))
