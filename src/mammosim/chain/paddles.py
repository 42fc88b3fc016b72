"""Paddles and supports by description: the one registry of what a strategy may say of a plate.

    paddle: {flexible: {...}, sloped: {angle_deg: 3}, curved: {across_radius_mm: 400}, cushion: {...}}

At most one part says how a paddle yields; shapes add up. What is not said is
flat, rigid and as large as the study's.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from mammosim.core.errors import ConfigurationError, MammosimError
from mammosim.core.settings import read
from mammosim.io.surfaces import digest_of
from mammosim.mechanics.described import Described, Size, Sloped
from mammosim.mechanics.effects import Cushion
from mammosim.mechanics.paddles import Flexible, Paddle, Rigid, Tilting
from mammosim.mechanics.plate_shapes import Curved, Function, Surface

_RIGID = Rigid()
# How a paddle yields: a class with the protocol Paddle.
YIELDS: Mapping[str, type[Paddle]] = {"tilting": Tilting, "flexible": Flexible}
# What shape its face has: a class with the protocol Shape.
SHAPES: Mapping[str, type] = {"curved": Curved, "function": Function, "surface": Surface}
PARTS: Mapping[str, type] = {**YIELDS, "sloped": Sloped, **SHAPES, "size": Size, "cushion": Cushion}


@dataclass(frozen=True)
class Plate:
    """One plate as a strategy describes it."""

    paddle: Paddle = _RIGID
    cushion: Cushion | None = None

    @classmethod
    def read(cls, values: Any, at: str) -> "Plate":
        """Of {name: {...}}, names of PARTS; nothing is flat and rigid. at: what an error calls them.

        Raises ConfigurationError for an unknown name, for a value that its part does not take, and for two
        ways to yield.
        """
        if not isinstance(values, Mapping) or not set(values) <= set(PARTS):
            unknown = next((repr(name) for name in values or () if name not in PARTS), "it")
            raise ConfigurationError(
                f"{at} = {values!r}; {unknown} is unknown, give one or more of: {', '.join(PARTS)}"
            )
        if len(both := [name for name in YIELDS if name in values]) > 1:
            raise ConfigurationError(f"{at} is both {' and '.join(both)}; a paddle yields in one way")
        parts: dict[str, Any] = {
            name: read(PARTS[name], given, f"{at}.{name}") for name, given in values.items()
        }
        yields = next((parts[name] for name in YIELDS if name in parts), Rigid())
        if set(parts) <= {*YIELDS, "cushion"}:
            return cls(yields, parts.get("cushion"))
        shapes = tuple(parts[name] for name in SHAPES if name in parts)
        size = parts.get("size", Size())
        if "surface" in parts:
            depth, width = (2 * half for half in parts["surface"].half_sizes)
            size = replace(size, width_mm=size.width_mm or width, depth_mm=size.depth_mm or depth)
        return cls(Described(yields, parts.get("sloped"), shapes, size), parts.get("cushion"))


def known_by_content(strategy: Mapping[str, Any], place: Callable[[str], str], *, at: str) -> dict[str, Any]:
    """The plain values of a strategy, in which each surface has the place of its file, and its digest.

    place: where a file is that a strategy names. Raises ConfigurationError, which begins with `at`, where
    there is no such file.
    """
    found = dict(strategy)
    for plate in ("paddle", "support"):
        given = (found.get(plate) or {}).get("surface")
        if given is None:
            continue
        file = place(given["file"])
        try:
            surface = {"file": file, "digest": digest_of(file)}
        except MammosimError:
            raise ConfigurationError(
                f"{at}.{plate}.surface: no file {given['file']}; correct the path, which begins where "
                "the study is run"
            ) from None
        found[plate] = {**found[plate], "surface": surface}
    return found
