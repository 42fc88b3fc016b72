"""The plates between which a breast is pressed: a support, and a paddle that is rigid, tilts or bends.

Either may have a shape and a size of its own: mechanics.described.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.errors import MechanicsError
from mammosim.core.units import MN_PER_N
from mammosim.mechanics.effects import BentBox, Cushion, RoundedBox
from mammosim.mechanics.flexible import Flexible

__all__ = ["Flexible", "Friction", "Paddle", "Plates", "Rigid", "Tilting"]

Face = RoundedBox | BentBox
# Points of the face along each axis where its largest deflection is looked for.
_SAMPLES = 33
# A steeper face comes back on itself: arcs along both axes, of 45 degrees each, are less.
_STEEPEST = 1.5


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

    def middle(self, half_sizes: np.ndarray) -> np.ndarray:
        """Where the middle of its face is (2,) mm, from the middle of both plates."""
        ...

    def rise(self, y: np.ndarray, box: RoundedBox, q: np.ndarray) -> np.ndarray:
        """How much further from the other plate the face is at places y (n, 2) than a flat one, mm.

        box: the flat one, its lower face in the plane of y, where the third coordinate is 0. NaN where a
        plate that is smaller does not reach.
        """
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

    def middle(self, half_sizes: np.ndarray) -> np.ndarray:
        """That of both plates."""
        return np.zeros(2)

    def rise(self, y: np.ndarray, box: RoundedBox, q: np.ndarray) -> np.ndarray:
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
        return turned(box, q[0], self.hinge)

    def middle(self, half_sizes: np.ndarray) -> np.ndarray:
        """That of both plates."""
        return np.zeros(2)

    def rise(self, y: np.ndarray, box: RoundedBox, q: np.ndarray) -> np.ndarray:
        """The plane through the hinge."""
        rise: np.ndarray = np.tan(q[0]) * (self.hinge * box.half_sizes[0] - y[:, 0])
        return rise

    def tilt_deg(self, q: np.ndarray) -> float:
        """The angle."""
        return float(np.degrees(q[0]))


def turned(box: RoundedBox, angle: float, hinge: float) -> RoundedBox:
    """A box turned by an angle, rad, about an axis across it in its lower face, at `hinge` from -1 to 1."""
    R = box.axes @ Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix()
    axis = np.array([hinge * box.half_sizes[0], 0.0, -box.half_sizes[2]])
    return RoundedBox(box.position(axis[None])[0] - R @ axis, R, box.half_sizes, box.radius)


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
    """Two plates, paddle and support, that face each other symmetrically about a centre.

    centre (3,) mm; axes (3, 3): orthonormal columns, the first from the chest outward, the last from the
    support to the paddle; half_sizes (3,) mm of each plate along them; edge_radius_mm of all edges: but for
    plates that are described smaller. friction: of both plates, None for none. support: described as a paddle
    that does not yield, away from the breast meaning downward. cushions: on paddle and support, or None.
    Raises MechanicsError for a support that yields.
    """

    centre: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray
    edge_radius_mm: float
    paddle: Paddle = Rigid()
    friction: Friction | None = None
    support: Paddle = Rigid()
    cushions: tuple[Cushion | None, Cushion | None] = (None, None)

    def __post_init__(self) -> None:
        if self.support.unknowns:
            raise MechanicsError("a support does not yield; describe its shape, its size or a cushion")

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

    def at(self, thickness_mm: float, q: np.ndarray | None = None) -> tuple[Face, Face]:
        """Paddle with unknowns q (m,), and support, thickness_mm apart before the paddle yields."""
        paddle, support = (
            RoundedBox(
                self.centre + side * (thickness_mm / 2 + self.half_sizes[2]) * self.axes[:, 2],
                self.axes * np.array([1.0, 1.0, side]),
                self.half_sizes,
                self.edge_radius_mm,
            )
            for side in (1, -1)
        )
        q = self.at_rest if q is None else q
        return self.paddle.placed(paddle, q), self.support.placed(support, np.zeros(0))

    @property
    def at_rest(self) -> np.ndarray:
        """q (m,) of a paddle that does not yield."""
        return np.zeros(self.paddle.unknowns)

    @property
    def flat(self) -> bool:
        """Whether at rest they are two flat plates of equal size."""
        whole = Rigid | Tilting | Flexible
        plates = isinstance(self.paddle, whole) and isinstance(self.support, whole)
        return plates and self.cushions == (None, None)

    @property
    def middle(self) -> np.ndarray:
        """Of the paddle's face (3,) mm, half way to the support."""
        middle: np.ndarray = self.centre + self.axes[:, :2] @ self.paddle.middle(self.half_sizes)
        return middle

    def first_contact(self, points: np.ndarray) -> float:
        """The largest distance between the faces at which a plate is in contact with points (n, 3), mm."""
        y, (paddle, support) = self._rises(points, self.at_rest)
        above, below = y[:, 2] - paddle, -y[:, 2] - support
        if np.isnan(above).all() or np.isnan(below).all():
            raise MechanicsError("no skin node lies between the plates; move their centre, or enlarge them")
        return 2 * float(max(np.nanmax(above), np.nanmax(below)))

    @property
    def _level(self) -> RoundedBox:
        """Either plate, flat, in the coordinates along the axes, its face in their plane."""
        level = np.array([0.0, 0.0, self.half_sizes[2]])
        return RoundedBox(level, np.eye(3), self.half_sizes, self.edge_radius_mm)

    def _rises(self, points: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
        """Coordinates (n, 3) of points along the axes, and the rise (n,) of paddle and support there."""
        y = (points - self.centre) @ self.axes
        under = np.all(np.abs(y[:, :2]) <= self.half_sizes[:2], axis=1)
        rises = (
            plate.rise(y[:, :2], self._level, unknowns)
            for plate, unknowns in ((self.paddle, q), (self.support, np.zeros(0)))
        )
        paddle, support = (np.where(under, rise, np.nan) for rise in rises)
        return y, (paddle, support)

    def gap(self, points: np.ndarray, thickness_mm: float, q: np.ndarray) -> np.ndarray:
        """Distance between the faces (n,) mm, along the last axis at points (n, 3); NaN beside a plate.

        thickness_mm: between the plates before the paddle yields; q (m,): its unknowns. Cushions are counted
        as they are without load.
        """
        _, (paddle, support) = self._rises(points, q)
        gap: np.ndarray = thickness_mm + paddle + support
        return gap

    def room(self, points: np.ndarray, thickness_mm: float, q: np.ndarray) -> tuple[float, float]:
        """How far paddle and support are beyond flat ones over points (n, 3) of the skin at most, mm.

        thickness_mm, q (m,): as in `gap`. Beside a smaller plate the skin itself counts.
        """
        y, (paddle, support) = self._rises(points, q)
        under = np.all(np.abs(y[:, :2]) <= self.half_sizes[:2], axis=1)
        above, below = (side * y[:, 2] - thickness_mm / 2 for side in (1, -1))
        paddle, support = (
            np.where(under & np.isnan(rise), skin, rise) for rise, skin in ((paddle, above), (support, below))
        )
        return float(np.nanmax(paddle)), float(np.nanmax(support))

    def require_possible(self, thickness_mm: float | None = None) -> None:
        """Raise MechanicsError where a face comes back on itself, or plates thickness_mm apart would meet."""
        for face, name in zip(self.at(0.0), ("paddle", "support")):
            y = self._grid(face)
            on_face = face.position(np.column_stack([y, np.full(len(y), -face.half_sizes[2])]))
            slope = np.sqrt(np.maximum(face.steepness(on_face) ** 2 - 1, 0.0)).max()
            if slope > _STEEPEST:
                raise MechanicsError(
                    f"the {name}'s face is as steep as {np.degrees(np.arctan(slope)):.0f} degrees and would "
                    f"come back on itself; up to {np.degrees(np.arctan(_STEEPEST)):.0f} degrees are possible"
                )
        if thickness_mm is not None:
            self.require_apart(thickness_mm, self.at_rest)

    def require_apart(self, thickness_mm: float, q: np.ndarray) -> None:
        """Raise MechanicsError where faces would meet; thickness_mm, q (m,): as in `gap`."""
        y = self._grid()
        places = self.centre + np.column_stack([y, np.zeros(len(y))]) @ self.axes.T
        gap = self.gap(places, thickness_mm, q)
        if np.isnan(gap).all():
            raise MechanicsError("paddle and support lie beside each other; move them, or enlarge them")
        if np.nanmin(gap) <= 0:
            u, v = y[np.nanargmin(gap)]
            raise MechanicsError(
                f"the paddle meets the support: at {thickness_mm:.1f} mm it would be "
                f"{-np.nanmin(gap):.1f} mm inside it, {u + self.half_sizes[0]:.0f} mm from the chest "
                f"edge and {v:.0f} mm across; ask for more thickness, or for flatter plates"
            )

    def _grid(self, face: Face | None = None) -> np.ndarray:
        """Places (n, 2) mm all over the plates, or all over one of them but for its round edges."""
        grid = np.linspace(-1.0, 1.0, _SAMPLES)
        half = self.half_sizes[:2] if face is None else face.half_sizes[:2] - face.radius
        grids: np.ndarray = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2) * half
        return grids

    def deflection_mm(self, q: np.ndarray) -> float:
        """How far the faces are from flat and level ones at most, with unknowns q (m,) of the paddle, mm."""
        y, box = self._grid(), self._level
        rises = self.paddle.rise(y, box, q), self.support.rise(y, box, np.zeros(0))
        return float(np.nanmax(np.abs(rises)))
