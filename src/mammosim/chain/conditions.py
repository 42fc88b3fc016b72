"""When a stage needs one of its products: decided by its own settings and effects."""

from mammosim.chain.graph import Inputs

STANDARD = {"thickness_share": 1.0}  # where the standard strategy stops, whose paddle is rigid
RELATIVE = {"force_share", "pressure_kpa"}  # criteria that are known only by the standard's load path


def is_moved(inputs: Inputs) -> bool:
    """Whether the measured position is moved into the frame of another one."""
    return bool(inputs.subject.moves)


def begins_with_mean(inputs: Inputs) -> bool:
    """Whether the first guess of the stress-free shape is the mean of two measured positions."""
    method, start = (inputs.setting(f"mechanics.stress_free.{name}") for name in ("default", "start"))
    return "mean_start" in (method, f"{start}_start")


def uses_standard(inputs: Inputs) -> bool:
    """Whether a strategy uses the standard's load path: as its own, to know its goal, or to continue it.

    With friction, which depends on the whole path, it is not continued.
    """
    strategy = inputs.setting("load.strategy")
    itself = strategy["until"] == STANDARD and not strategy.get("paddle")
    return itself or bool(RELATIVE & set(strategy["until"])) or not inputs.has("friction")


def is_scattered(inputs: Inputs) -> bool:
    """Whether photons are scattered into the image."""
    return inputs.has("scatter")
