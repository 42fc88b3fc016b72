"""How a body of the hard cases is pressed: plates across y, whose chest edge faces the chest wall z = 0."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.compression import compress
from mammosim.mechanics.effects import Effect
from mammosim.mechanics.equilibrium import Equilibrium
from mammosim.mechanics.paddles import Flexible, Friction, Paddle, Plates, Rigid, Tilting
from mammosim.mechanics.stage import Control, Force, Thickness

# The first axis points outward along z, the last, from support to paddle, along y.
_AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T
_HALF_DEPTH_MM, _HALF_HEIGHT_MM = 60.0, 15.0
PADDLES: Mapping[str, type] = {"rigid": Rigid, "tilting": Tilting, "flexible": Flexible}


@dataclass(frozen=True)
class Pressing:
    """Plates, and to what they press."""

    plates: Plates
    control: Control

    @classmethod
    def of(
        cls,
        *,
        edge_radius_mm: float,
        chest_edge_mm: float,
        thickness_mm: float | None = None,
        force_n: float | None = None,
        half_width_mm: float = 80.0,
        **yields: Any,
    ) -> "Pressing":
        """Between plates that begin at z = chest_edge_mm; yields: see _paddle."""
        centre = np.array([0.0, 0.0, chest_edge_mm + _HALF_DEPTH_MM])
        half = np.array([_HALF_DEPTH_MM, half_width_mm, _HALF_HEIGHT_MM])
        paddle, friction = _paddle(**yields)
        plates = Plates(centre, _AXES, half, edge_radius_mm, paddle, friction)
        control: Control = Force(force_n) if force_n is not None else Thickness(thickness_mm or 0.0)
        return cls(plates, control)

    def turned(self, R: np.ndarray) -> "Pressing":
        """The plates turned by R (3, 3) about the origin."""
        plates = self.plates
        return replace(self, plates=replace(plates, centre=R @ plates.centre, axes=R @ plates.axes))

    def equilibrium(self, mesh: TetMesh, effects: tuple[Effect, ...], held: np.ndarray | None) -> Equilibrium:
        """The state at the end. Raises as mechanics.compression.compress does."""
        return compress(mesh, effects, plates=self.plates, control=self.control, held=held).equilibrium


def _paddle(
    *, friction: float | None = None, paddle: Mapping[str, Any] | None = None
) -> tuple[Paddle, Friction | None]:
    """friction: the coefficient; paddle: {name of PADDLES: its values}."""
    ((name, values),) = (paddle or {"rigid": {}}).items()
    return PADDLES[name](**values), None if friction is None else Friction(friction)
