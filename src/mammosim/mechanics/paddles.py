"""The plates between which a breast is pressed: a support, and a paddle that is rigid, tilts or bends."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.errors import MechanicsError
from mammosim.core.units import MN_PER_N
from mammosim.mechanics.effects import BentBox, RoundedBox
from mammosim.mechanics.flexible import Flexible

__all__ = ["Flexible", "Friction", "Paddle", "Plates", "Rigid", "Tilting"]

Face = RoundedBox | BentBox
# Points of the face along each axis where its largest deflection is looked for.
_SAMPLES = 33


class Paddle(Protocol):
    """How a paddle yields: m unknowns q, energy 1/2 q . K q."""

    @property
    def unknowns(self) -> int:
        """m."""

    def stiffness(self, half_sizes: np.ndarray) -> np.ndarray:
        """K (m, m), mN per unit of q."""
        ...

    def reach(self, half_sizes: np.ndarray) -> np.ndarray:
        """How far the face moves at most for a unit of each unknown (m,), mm."""
        ...

    def placed(self, box: RoundedBox, q: np.ndarray) -> Face:
        """The paddle that stands in its place as `box`, with unknowns q (m,)."""
        ...

    def rise(self, y: np.ndarray, half_sizes: np.ndarray, q: np.ndarray) -> np.ndarray:
        """How much further from the support the face is at places y (n, 2) than a rigid one, mm."""
        ...

    def tilt_deg(self, q: np.ndarray) -> float:
        """Its rotation, positive where it opens toward the chest."""
        ...


@dataclass(frozen=True)
class Rigid:
    """A paddle that does not yield."""

    unknowns: int = field(default=0, init=False)

    def stiffness(self, half_sizes: np.ndarray) -> np.ndarray:
        """Nothing to be stiff."""
        return np.zeros((0, 0))

    def reach(self, half_sizes: np.ndarray) -> np.ndarray:
        """Nothing moves."""
        return np.zeros(0)

    def placed(self, box: RoundedBox, q: np.ndarray) -> RoundedBox:
        """As it is."""
        return box

    def rise(self, y: np.ndarray, half_sizes: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Zero everywhere."""
        return np.zeros(len(y))

    def tilt_deg(self, q: np.ndarray) -> float:
        """None."""
        return 0.0


@dataclass(frozen=True)
class Tilting:
    """A rigid paddle on a spring hinge, an axis across the plate in its face; q: the angle, rad.

    hinge: where it is, from -1 at the chest edge to 1 at the arm. Raises MechanicsError for a stiffness <= 0
    or a hinge off the plate.
    """

    # ASSUME: the spring of the hinge is linear, and without a stop.

    stiffness_n_mm_per_rad: float
    hinge: float = 0.0

    unknowns: int = field(default=1, init=False)

    def __post_init__(self) -> None:
        if not self.stiffness_n_mm_per_rad > 0 or not -1 <= self.hinge <= 1:
            raise MechanicsError(
                f"a hinge of {self.stiffness_n_mm_per_rad:g} N mm/rad (above 0) at {self.hinge:g} "
                "(from -1, the chest edge, to 1, the arm)"
            )

    def stiffness(self, half_sizes: np.ndarray) -> np.ndarray:
        """K (1, 1) mN mm/rad."""
        return np.array([[MN_PER_N * self.stiffness_n_mm_per_rad]])

    def reach(self, half_sizes: np.ndarray) -> np.ndarray:
        """From the hinge to the further edge, mm/rad."""
        return np.array([half_sizes[0] * (1 + abs(self.hinge))])

    def placed(self, box: RoundedBox, q: np.ndarray) -> RoundedBox:
        """Turned about the hinge, so that a positive angle opens toward the chest."""
        R = box.axes @ Rotation.from_rotvec([0.0, q[0], 0.0]).as_matrix()
        axis = np.array([self.hinge * box.half_sizes[0], 0.0, -box.half_sizes[2]])
        return RoundedBox(box.position(axis[None])[0] - R @ axis, R, box.half_sizes, box.radius)

    def rise(self, y: np.ndarray, half_sizes: np.ndarray, q: np.ndarray) -> np.ndarray:
        """The plane through the hinge."""
        rise: np.ndarray = np.tan(q[0]) * (self.hinge * half_sizes[0] - y[:, 0])
        return rise

    def tilt_deg(self, q: np.ndarray) -> float:
        """The angle."""
        return float(np.degrees(q[0]))


# ASSUME: skin creeps 0.1 mm before it slips on a plate; static and sliding friction are equal.
@dataclass(frozen=True)
class Friction:
    """Coulomb: sticks up to slip_mm with a force that rises to coefficient times the normal one.

    Raises MechanicsError for a negative coefficient, or slip_mm <= 0.
    """

    coefficient: float
    slip_mm: float = 0.1

    def __post_init__(self) -> None:
        if not self.coefficient >= 0 or not self.slip_mm > 0:
            raise MechanicsError(
                f"friction of {self.coefficient:g} (at least 0) with a slip of {self.slip_mm:g} mm (above 0)"
            )


@dataclass(frozen=True)
class Plates:
    """Two plates of equal size, paddle and support, that face each other symmetrically about a centre.

    centre (3,) mm; axes (3, 3): orthonormal columns, the first from the chest outward, the last from the
    support to the paddle; half_sizes (3,) mm of each plate along them; edge_radius_mm of all edges.
    friction: of both plates, None for none.
    """

    centre: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray
    edge_radius_mm: float
    paddle: Paddle = Rigid()
    friction: Friction | None = None

    @classmethod
    def covering(
        cls,
        points: np.ndarray,
        *,
        direction: np.ndarray,
        outward: np.ndarray,
        margin_mm: float = 20.0,
        plate_thickness_mm: float = 20.0,
        edge_radius_mm: float = 8.0,
    ) -> "Plates":
        """Plates across `direction` (3,) that cover points (n, 3) and margin_mm around, but none behind them.

        plate_thickness_mm, edge_radius_mm: of each plate.
        outward (3,): from the chest wall to the nipple; behind the points, the plates end where the points
        do.
        """
        a = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
        b = np.asarray(outward, dtype=float) - np.dot(outward, a) * a
        b /= np.linalg.norm(b)
        axes = np.column_stack([b, np.cross(a, b), a])
        low, high = (points @ axes).min(axis=0), (points @ axes).max(axis=0)
        low = low - np.array([0.0, margin_mm, 0.0])
        high = high + np.array([margin_mm, margin_mm, 0.0])
        half = (high - low) / 2
        half[2] = plate_thickness_mm / 2
        return cls(axes @ (low + high) / 2, axes, half, edge_radius_mm)

    def at(self, thickness_mm: float, q: np.ndarray | None = None) -> tuple[Face, RoundedBox]:
        """Paddle with unknowns q (m,), and support, thickness_mm apart before the paddle yields."""
        reach = (thickness_mm / 2 + self.half_sizes[2]) * self.axes[:, 2]
        paddle, support = (
            RoundedBox(self.centre + side * reach, self.axes, self.half_sizes, self.edge_radius_mm)
            for side in (1, -1)
        )
        return self.paddle.placed(paddle, self.at_rest if q is None else q), support

    @property
    def at_rest(self) -> np.ndarray:
        """q (m,) of a paddle that does not yield."""
        return np.zeros(self.paddle.unknowns)

    def first_contact(self, points: np.ndarray) -> float:
        """The largest distance between the faces at which a plate is in contact with points (n, 3), mm."""
        y = (points - self.centre) @ self.axes
        under = np.all(np.abs(y[:, :2]) <= self.half_sizes[:2], axis=1)
        if not under.any():
            raise MechanicsError("no skin node lies between the plates; move their centre, or enlarge them")
        return 2 * float(np.abs(y[under, 2]).max())

    def gap(self, points: np.ndarray, thickness_mm: float, q: np.ndarray) -> np.ndarray:
        """Distance between the faces (n,) mm, along the last axis at points (n, 3); NaN beside the plates.

        thickness_mm: between the plates before the paddle yields; q (m,): its unknowns.
        """
        y = ((points - self.centre) @ self.axes)[:, :2]
        gap = thickness_mm + self.paddle.rise(y, self.half_sizes, q)
        return np.where(np.all(np.abs(y) <= self.half_sizes[:2], axis=1), gap, np.nan)

    def deflection_mm(self, q: np.ndarray) -> float:
        """How far the paddle's face has yielded at most with unknowns q (m,), mm."""
        grid = np.linspace(-1.0, 1.0, _SAMPLES)
        y = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2) * self.half_sizes[:2]
        return float(np.abs(self.paddle.rise(y, self.half_sizes, q)).max())
