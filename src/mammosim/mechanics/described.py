"""A plate by description: how it yields, how it stands, the shape of its face, its size and its edges.

The face is that of a rigid, tilting or flexible paddle, its deflection the sum of all: w = sum of w_i.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import BentBox, RoundedBox, ShapedBox
from mammosim.mechanics.effects.plate import Deflection
from mammosim.mechanics.paddles import Face, Paddle, Rigid, turned
from mammosim.mechanics.plate_shapes import Shape, Total

_RIGID = Rigid()
_LARGEST_ANGLE_DEG = 30.0
_MOST_TURNS, _FOUND_MM = 60, 1e-10


@dataclass(frozen=True)
class Sloped:
    """A plate that stands at an angle, turned about an axis across it in its face.

    angle_deg: positive where it opens toward the chest; hinge: where the axis is, and the machine reads the
    distance, from -1 at the chest edge to 1 at the arm. Raises MechanicsError for values out of range.
    """

    angle_deg: float
    hinge: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.angle_deg) <= _LARGEST_ANGLE_DEG or not -1 <= self.hinge <= 1:
            raise MechanicsError(
                f"a slope of {self.angle_deg:g} degrees (at most {_LARGEST_ANGLE_DEG:g}) at {self.hinge:g} "
                "(from -1, the chest edge, to 1, the arm)"
            )

    def placed(self, box: RoundedBox) -> RoundedBox:
        """The box turned."""
        return turned(box, float(np.radians(self.angle_deg)), self.hinge)


@dataclass(frozen=True)
class Size:
    """Of a plate that is smaller than the study's, mm; what is None is as the study's.

    width: across, in the middle but for across_mm; depth: outward, from from_chest_mm behind the chest edge
    on; height: its thickness, at least twice edge_radius_mm. Raises MechanicsError unless above 0.
    """

    width_mm: float | None = None
    depth_mm: float | None = None
    height_mm: float | None = None
    edge_radius_mm: float | None = None
    from_chest_mm: float = 0.0
    across_mm: float = 0.0

    def __post_init__(self) -> None:
        given = [
            x for x in (self.width_mm, self.depth_mm, self.height_mm, self.edge_radius_mm) if x is not None
        ]
        if not all(0 < x < np.inf for x in given) or not 0 <= self.from_chest_mm < np.inf:
            raise MechanicsError(
                f"a plate of {self.width_mm} x {self.depth_mm} x {self.height_mm} mm, edge radius "
                f"{self.edge_radius_mm} mm, {self.from_chest_mm} mm from the chest edge: above 0, the "
                "last at least 0"
            )

    def half_sizes(self, whole: np.ndarray) -> np.ndarray:
        """Of the plate (3,) mm, where the study's has `whole` (3,)."""
        own = (self.depth_mm, self.width_mm, self.height_mm)
        return np.array([half if mm is None else mm / 2 for mm, half in zip(own, whole)])

    def middle(self, whole: np.ndarray) -> np.ndarray:
        """Of the plate (2,) mm from that of the study's."""
        return np.array([self.half_sizes(whole)[0] - whole[0] + self.from_chest_mm, self.across_mm])

    def placed(self, box: RoundedBox) -> RoundedBox:
        """The plate with its face where that of a box is."""
        self.require_within(box.half_sizes)
        half = self.half_sizes(box.half_sizes)
        shift = np.array([*self.middle(box.half_sizes), half[2] - box.half_sizes[2]])
        radius = box.radius if self.edge_radius_mm is None else self.edge_radius_mm
        return RoundedBox(box.centre + box.axes @ shift, box.axes, half, radius)

    def require_within(self, whole: np.ndarray) -> None:
        """Raise MechanicsError where the plate is larger than the study's, which keep clear of the chest."""
        beyond = np.abs(self.middle(whole)) + self.half_sizes(whole)[:2] - whole[:2]
        if beyond.max() > 1e-6:
            mm = 2 * self.half_sizes(whole)
            raise MechanicsError(
                f"a plate of width {mm[1]:g} and depth {mm[0]:g} mm, {self.from_chest_mm:g} mm from the "
                f"chest edge and {self.across_mm:g} mm across, does not lie within {2 * whole[1]:g} x "
                f"{2 * whole[0]:g} mm, compression.plate_mm: enlarge that, or reduce the plate"
            )


@dataclass(frozen=True)
class Described:
    """A Paddle of parts: how it yields, where it stands, its shapes and its size."""

    yields: Paddle = _RIGID
    slope: Sloped | None = None
    shapes: tuple[Shape, ...] = ()
    size: Size = field(default_factory=Size)

    @property
    def unknowns(self) -> int:
        """Of how it yields."""
        return self.yields.unknowns

    def stiffness(self, half_sizes: np.ndarray) -> np.ndarray:
        """See Paddle."""
        return self.yields.stiffness(self.size.half_sizes(half_sizes))

    def reach(self, half_sizes: np.ndarray) -> np.ndarray:
        """See Paddle."""
        return self.yields.reach(self.size.half_sizes(half_sizes))

    def middle(self, half_sizes: np.ndarray) -> np.ndarray:
        """See Paddle."""
        return self.size.middle(half_sizes)

    def placed(self, box: RoundedBox, q: np.ndarray) -> Face:
        """See Paddle: made smaller, sloped, yielding, and shaped."""
        box = self.size.placed(box)
        face = self.yields.placed(box if self.slope is None else self.slope.placed(box), q)
        if not self.shapes:
            return face
        half = (float(box.half_sizes[0]), float(box.half_sizes[1]))
        shape = _over(self.shapes, half, box.radius)
        if isinstance(face, BentBox):
            return ShapedBox(face.box, Total((shape, face.deflection)))
        return ShapedBox(face, shape)

    def rise(self, y: np.ndarray, box: RoundedBox, q: np.ndarray) -> np.ndarray:
        """See Paddle."""
        beside = np.abs(y - self.size.middle(box.half_sizes)) > self.size.half_sizes(box.half_sizes)[:2]
        return np.where(beside.any(axis=1), np.nan, _height(self.placed(box, q), y))

    def tilt_deg(self, q: np.ndarray) -> float:
        """See Paddle."""
        return self.yields.tilt_deg(q) + (0.0 if self.slope is None else self.slope.angle_deg)


@lru_cache(maxsize=32)
def _over(shapes: tuple[Shape, ...], half_sizes: tuple[float, float], edge_radius_mm: float) -> Deflection:
    """The sum of shapes on a plate."""
    return Total(tuple(shape.over(half_sizes, edge_radius_mm) for shape in shapes))


def _height(face: Face, y: np.ndarray) -> np.ndarray:
    """The third coordinate (n,) of a face over its first two, y (n, 2), found by repetition.

    A place u of the plate is over x(u): u rises by y - x(u) until they agree.
    """
    u = y.copy()
    for _ in range(_MOST_TURNS):
        x = face.position(np.column_stack([u, np.full(len(u), -face.half_sizes[2])]))
        off = y - x[:, :2]
        if np.abs(off).max(initial=0.0) < _FOUND_MM:
            return x[:, 2]
        u = u + off
    raise MechanicsError("a plate is so steep that it overhangs; make it flatter")
