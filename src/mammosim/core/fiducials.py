"""Named points on a volunteer: markers and nipples, in mm, in the patient frame LPS."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from mammosim.core.errors import FiducialError

KINDS = ("chest", "breast", "nipple")
NIPPLES = ("nipple_left", "nipple_right")
# Those of a complete list; there may be more of a kind.
NAMES = (*(f"chest_{n}" for n in range(1, 5)), *(f"breast_{n}" for n in range(1, 7)), *NIPPLES)
# ASSUME: the frame of a scan begins at the midline, to 30 mm; that of a label map may begin anywhere.
OFF_MM = 30.0
NUMBERED = re.compile(r"(chest|breast)_?0*([1-9][0-9]*)")
SIDED = re.compile(r"nipple_?(left|right)|(left|right)_?nipple")


@dataclass(frozen=True)
class Fiducials:
    """names (n,) unique; kinds (n,) of KINDS; points (n, 3) mm.

    Names: chest_1..4, breast_1..6 (an unmatched detection is numbered as found), nipple_left, nipple_right.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    points: np.ndarray

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.kinds) == len(self.points):
            raise FiducialError(
                f"{len(self.names)} names, {len(self.kinds)} kinds and {len(self.points)} points differ"
            )
        if unknown := set(self.kinds) - set(KINDS):
            raise FiducialError(f"unknown kind {sorted(unknown)}; choose one of: {', '.join(KINDS)}")
        if twice := sorted({name for name in self.names if self.names.count(name) > 1}):
            raise FiducialError(
                f"{twice[0]} stands twice; fiducial names must be unique: rename or delete one"
            )

    def of_kind(self, kind: str) -> np.ndarray:
        """Points (m, 3) of one kind, in the order of the list."""
        return self.points[[k == kind for k in self.kinds]]

    def point(self, name: str) -> np.ndarray:
        """One point (3,). Raises FiducialError when the list has no such name."""
        if name not in self.names:
            listed = f"the list has: {', '.join(self.names)}" if self.names else "the list has no point"
            raise FiducialError(
                f"no fiducial {name!r}; {listed}; mark it in the image, and add it to the list"
            )
        x: np.ndarray = self.points[self.names.index(name)]
        return x


def midline_of(middle_mm: float) -> float:
    """x of the midline of a body whose sides' middle is at x = middle_mm: 0 where its frame begins there."""
    return middle_mm if abs(middle_mm) > OFF_MM else 0.0


def midline_mm(fiducials: Fiducials) -> float:
    """x of the plane between her sides, by both nipples, in their frame; 0 where one is not listed."""
    x = fiducials.of_kind("nipple")[:, 0]
    return midline_of(float(x.mean())) if len(x) == len(NIPPLES) else 0.0


def usual_name(written: str) -> str:
    """The name that is meant by 'Breast 1', 'nipple-left' or 'Left nipple '; '' where none is."""
    plain = re.sub(r"[\s_.-]+", "_", written.strip().lower())
    if found := NUMBERED.fullmatch(plain):
        return f"{found[1]}_{found[2]}"
    found = SIDED.fullmatch(plain)
    return f"nipple_{found[1] or found[2]}" if found else ""


def kind_of(name: str) -> str:
    """The kind that a name begins with."""
    return name.split("_")[0]


def advice_on(unknown: str, listed: Iterable[str]) -> str:
    """What to do about a name that is none: the missing one that it is most like, else all of them."""
    missing = [name for name in NAMES if name not in set(listed)]
    near = get_close_matches(unknown.strip().lower(), missing, n=1, cutoff=0.7)
    if near:
        return f"{near[0]} is missing, did you mean that? rename the point"
    return "name the points chest_1 to chest_4, breast_1 to breast_6, nipple_left and nipple_right"
