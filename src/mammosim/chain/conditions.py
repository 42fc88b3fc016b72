"""When a stage needs one of its products: decided by its own settings and effects."""

from collections.abc import Mapping
from typing import Any

from mammosim.chain.graph import Inputs

STANDARD = {"thickness_share": 1.0}  # where the standard strategy stops, whose plates are flat and rigid
YIELDING = ("tilting", "flexible")  # names of chain.paddles.YIELDS: paddles that begin flat
UNDER_GRAVITY = "gravity"  # the set of moduli by which a breast carries its weight
RELATIVE = {"force_share", "pressure_kpa"}  # criteria that are known only by the standard's load path


def is_moved(inputs: Inputs) -> bool:
    """Whether the measured position is moved into the frame of another one."""
    return bool(inputs.subject.moves)


def is_labelled(inputs: Inputs) -> bool:
    """Whether labels are given in the place of a segmentation."""
    return "labels" in inputs.subject.has


def is_segmented(inputs: Inputs) -> bool:
    """Whether its image is segmented."""
    return not is_labelled(inputs)


def is_painted(inputs: Inputs) -> bool:
    """Whether strokes are given, from which tissues are learnt."""
    return "strokes" in inputs.subject.has


def is_marked(inputs: Inputs) -> bool:
    """Whether a list of its markers and nipples is given."""
    return "fiducials" in inputs.subject.has


def is_unmarked(inputs: Inputs) -> bool:
    """Whether its nipples are to be found in its labels."""
    return not is_marked(inputs)


def finds_markers(inputs: Inputs) -> bool:
    """Whether chest markers are looked for in the image: by them positions are brought into one frame."""
    found = inputs.setting("registration.chest_markers") == "found"
    return found and is_marked(inputs) and "reference" in inputs.subject.has


def begins_with_mean(inputs: Inputs) -> bool:
    """Whether the first guess of the stress-free shape is the mean of two measured positions."""
    method, start = (inputs.setting(f"mechanics.stress_free.{name}") for name in ("default", "start"))
    return "mean_start" in (method, f"{start}_start")


def uses_standard(inputs: Inputs) -> bool:
    """Whether a strategy uses the standard's load path: as its own, to know its goal, or to continue it.

    With friction, which depends on the whole path, it is not continued, nor by plates that are not flat.
    """
    strategy = inputs.setting("load.strategy")
    continued = is_flat(strategy) and not inputs.has("friction")
    return is_standard(strategy) or bool(RELATIVE & set(strategy["until"])) or continued


def is_flat(strategy: Mapping[str, Any]) -> bool:
    """Whether its plates begin as the standard's are: a paddle may yield, and nothing else is said."""
    parts = list(strategy.get("paddle") or ())
    return len(parts) <= 1 and set(parts) <= set(YIELDING) and not strategy.get("support")


def is_standard(strategy: Mapping[str, Any]) -> bool:
    """Whether a strategy is the standard one."""
    plates = strategy.get("paddle") or strategy.get("support")
    return strategy.get("until") == STANDARD and not plates


def is_under_gravity(inputs: Inputs) -> bool:
    """Whether what is pressed has the moduli that carry the weight, and no other set."""
    return bool(inputs.setting("load.moduli") == UNDER_GRAVITY)


def is_scattered(inputs: Inputs) -> bool:
    """Whether photons are scattered into the image."""
    return inputs.has("scatter")
