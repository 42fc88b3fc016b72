"""The shape of a plate's face: how much further from the breast than a flat one it is, w(y) mm.

y are places (outward from the chest, across) mm from the middle of the plate. An arc of radius r has

    w = y^2 / (r + sqrt(r^2 - y^2)),  w' = y / sqrt(r^2 - y^2),  w'' = r^2 / (r^2 - y^2)^(3/2)

and goes on straight where its slope is 2; no plate may be as steep as that.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.formula import Formula
from mammosim.io.surfaces import digest_of, read_closed_surface
from mammosim.mechanics.effects.plate import Deflection
from mammosim.mechanics.height_map import HeightMap
from mammosim.mechanics.surface_heights import faces_below

# Samples of a formula or a surface are this far apart, and reach as far beyond the plate.
_SPACING_MM, _BEYOND_MM = 2.0, 10.0
_STEEPEST_ARC = 2.0
# A spline through the samples of a surface may be this far from it.
_SURFACE_TOLERANCE_MM = 0.3


class Shape(Protocol):
    """What a face looks like on a plate of any size. Hashable."""

    def over(self, half_sizes: tuple[float, float], edge_radius_mm: float) -> Deflection:
        """w on a plate of half sizes (outward, across) mm, whose edges are rounded."""
        ...


@dataclass(frozen=True)
class Total:
    """The sum of deflections: a Deflection."""

    parts: tuple[Deflection, ...]

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See Deflection."""
        w, slope, second = self.parts[0].at(y)
        for part in self.parts[1:]:
            more = part.at(y)
            w, slope, second = w + more[0], slope + more[1], second + more[2]
        return w, slope, second


@dataclass(frozen=True)
class Curved:
    """Arcs along the two axes of a plate, in its middle as far away as a flat one: a Shape and a Deflection.

    Radii in mm: positive where the face is convex, its edges away from the breast, negative where it is
    hollow and holds the breast; None is straight. Raises MechanicsError for two that are None, or for 0.
    """

    outward_radius_mm: float | None = None
    across_radius_mm: float | None = None

    def __post_init__(self) -> None:
        radii = [r for r in self._radii if r is not None]
        if not radii or not all(np.isfinite(r) and r != 0 for r in radii):
            raise MechanicsError(
                f"a face of radii {self.outward_radius_mm} mm outward and {self.across_radius_mm} mm across: "
                "give one of them or both, positive for a convex face, negative for a hollow one"
            )

    @property
    def _radii(self) -> tuple[float | None, float | None]:
        return self.outward_radius_mm, self.across_radius_mm

    def over(self, half_sizes: tuple[float, float], edge_radius_mm: float) -> Deflection:
        """The same on every plate that the arcs span. Raises MechanicsError for another one."""
        for r, half, name in zip(self._radii, half_sizes, ("outward", "across")):
            if r is not None and abs(r) <= np.sqrt(2) * half:
                raise MechanicsError(
                    f"a face of {name}_radius_mm = {r:g} would be steeper than 45 degrees, and come back on "
                    f"itself: a plate of {2 * half:g} mm asks for more than {np.sqrt(2) * half:.0f} mm"
                )
        return self

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See Deflection."""
        w, slope, second = np.zeros(len(y)), np.zeros((len(y), 2)), np.zeros((len(y), 2, 2))
        for i, r in enumerate(self._radii):
            if r is not None:
                arc = _arc(y[:, i], r)
                w += arc[0]
                slope[:, i], second[:, i, i] = arc[1], arc[2]
        return w, slope, second


def _arc(y: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """w (n,) of an arc at y (n,), w' and w''."""
    r, side = abs(radius), np.sign(radius)
    end = r * _STEEPEST_ARC / np.hypot(1, _STEEPEST_ARC)
    t = np.clip(y, -end, end)
    root = np.sqrt(r**2 - t**2)
    straight = np.abs(y) > end
    w = t**2 / (r + root) + np.where(straight, _STEEPEST_ARC * (np.abs(y) - end), 0.0)
    return side * w, side * t / root, np.where(straight, 0.0, side * r**2 / root**3)


@dataclass(frozen=True)
class FromFunction:
    """A face by a function of `outward` (n,), from the chest edge, and `across` (n,), from the middle, mm.

    rise_mm gives (n,) mm, positive away from the breast; 0 where the machine reads the distance.
    It is asked up to 10 mm beyond the plate, every 2 mm; between, a bicubic spline is the face.
    """

    rise_mm: Callable[[np.ndarray, np.ndarray], np.ndarray]

    def over(self, half_sizes: tuple[float, float], edge_radius_mm: float) -> Deflection:
        """The spline. Raises MechanicsError where the function has no finite value."""
        grid = _grid(half_sizes)
        outward, across = np.meshgrid(*grid, indexing="ij")
        with np.errstate(all="ignore"):
            heights = np.broadcast_to(self.rise_mm(outward + half_sizes[0], across), outward.shape)
        if not np.all(np.isfinite(heights)):
            i, j = np.argwhere(~np.isfinite(heights))[0]
            raise MechanicsError(
                f"rise_mm has no finite value {grid[0][i] + half_sizes[0]:g} mm outward from the chest edge, "
                f"{grid[1][j]:g} mm across; it must have one up to {_BEYOND_MM:g} mm beyond the plate"
            )
        return _through(grid, np.array(heights, dtype=float))


@dataclass(frozen=True)
class Function:
    """A face by a formula of `outward` and `across`, as in FromFunction: `across**2 / 400`.

    Numbers, + - * / **, brackets, and the functions of core.formula. Raises ConfigurationError for others.
    """

    rise_mm: str

    def __post_init__(self) -> None:
        Formula.read(self.rise_mm, ("outward", "across"))

    def over(self, half_sizes: tuple[float, float], edge_radius_mm: float) -> Deflection:
        """See FromFunction."""
        formula = Formula.read(self.rise_mm, ("outward", "across"))

        def rise_mm(outward: np.ndarray, across: np.ndarray) -> np.ndarray:
            return formula({"outward": outward, "across": across})

        return FromFunction(rise_mm).over(half_sizes, edge_radius_mm)


@dataclass(frozen=True)
class Surface:
    """A face by a closed surface in an STL file, in mm: what is pressed on a breast is seen from below.

    Its x runs from the chest outward, y across, z away from the breast; the chest edge is at its least x, the
    middle at that of its y; where it is nearest to the breast the machine reads the distance of the plates.
    digest: of the file (io.surfaces.digest_of), '' for any. Raises MeshError for a file that is not closed,
    not in mm or another one; MechanicsError where what is drawn meets itself.
    """

    # ASSUME: within a plate's edge radius of its sides a surface goes on straight.

    file: str
    digest: str = ""

    def __post_init__(self) -> None:
        if self.digest and digest_of(self.file) != self.digest:
            raise MechanicsError(f"{self.file} has changed since the run began; start again")
        _heights(self.file, digest_of(self.file))

    @property
    def half_sizes(self) -> tuple[float, float]:
        """Of the surface seen from above (outward, across), mm."""
        return _heights(self.file, digest_of(self.file))[0]

    def over(self, half_sizes: tuple[float, float], edge_radius_mm: float) -> Deflection:
        """A spline through the surface. Raises MechanicsError for a larger plate, or a rough surface."""
        drawn, face = _heights(self.file, digest_of(self.file))
        if half_sizes[0] > drawn[0] + 1e-6 or half_sizes[1] > drawn[1] + 1e-6:
            raise MechanicsError(
                f"{self.file} covers {2 * drawn[0]:g} x {2 * drawn[1]:g} mm, the plate has "
                f"{2 * half_sizes[0]:g} x {2 * half_sizes[1]:g} mm: reduce its size"
            )
        inside = (half_sizes[0] - edge_radius_mm, half_sizes[1] - edge_radius_mm)
        # The chest edges of plate and surface are at one place.
        shift = drawn[0] - half_sizes[0]

        def heights(u: np.ndarray, v: np.ndarray) -> np.ndarray:
            return _gone_on(lambda u, v: face(u - shift, v), u, v, inside)

        grid = _grid(half_sizes)
        sampled = heights(*grid)
        lowest = heights(*(np.clip(g, -half, half) for g, half in zip(grid, half_sizes))).min()
        found = _through(grid, sampled - lowest)
        between = [np.clip((g[1:] + g[:-1]) / 2, -end, end) for g, end in zip(grid, inside)]
        y = np.stack(np.meshgrid(*between, indexing="ij"), axis=-1).reshape(-1, 2)
        off = np.abs(found.at(y)[0] + lowest - heights(*between).ravel()).max()
        if off > _SURFACE_TOLERANCE_MM:
            raise MechanicsError(
                f"{self.file} has steps or edges on its face: a smooth one is {off:.1f} mm off, at most "
                f"{_SURFACE_TOLERANCE_MM:g} mm; smooth it, or leave its rim to the edge radius of the plate"
            )
        return found


Heights = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _gone_on(face: Heights, u: np.ndarray, v: np.ndarray, inside: tuple[float, float]) -> np.ndarray:
    """Heights (n, m) of a face over u (n,) and v (m,), which beyond +-inside go on straight."""
    uc, vc = np.clip(u, -inside[0], inside[0]), np.clip(v, -inside[1], inside[1])
    step, ends = _SPACING_MM, np.array([-1.0, 1.0])
    across, along = (end * ends for end in inside)
    rising_u = (face(across, vc) - face(across - step * ends, vc)) / step
    rising_v = (face(uc, along) - face(uc, along - step * ends)) / step
    beyond_u, beyond_v = np.abs(u - uc)[:, None], np.abs(v - vc)[None]
    left, low = (u < uc)[:, None], (v < vc)[None]
    more_u = beyond_u * np.where(left, rising_u[:1], rising_u[1:])
    more_v = beyond_v * np.where(low, rising_v[:, :1], rising_v[:, 1:])
    heights: np.ndarray = face(uc, vc) + more_u + more_v
    return heights


@lru_cache(maxsize=16)
def _heights(file: str, digest: str) -> tuple[tuple[float, float], Heights]:
    """Half sizes of a surface, and its height over places (outward (n,), across (m,)) from its middle, mm."""
    surface = read_closed_surface(file)
    low, high = surface.low, surface.high
    middle = (low + high) / 2

    def face(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return faces_below(surface, middle[0] + u, middle[1] + v, name=file)

    half = (float(high[0] - low[0]) / 2, float(high[1] - low[1]) / 2)
    face(np.linspace(-half[0], half[0], 81)[8:-8], np.linspace(-half[1], half[1], 81)[8:-8])
    return half, face


def _grid(half_sizes: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Places of samples along each axis, mm from the middle."""
    ends = [half + _BEYOND_MM for half in half_sizes]
    outward, across = (np.linspace(-end, end, int(np.ceil(2 * end / _SPACING_MM)) + 1) for end in ends)
    return outward, across


def _through(grid: tuple[np.ndarray, np.ndarray], heights: np.ndarray) -> HeightMap:
    spacing = np.array([g[1] - g[0] for g in grid])
    return HeightMap.through(np.array([grid[0][0], grid[1][0]]), spacing, heights)
