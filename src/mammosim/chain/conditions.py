"""When a stage needs one of its products: decided by its own settings and effects."""

from mammosim.chain.graph import Inputs


def is_moved(inputs: Inputs) -> bool:
    """Whether the measured position is moved into the frame of another one."""
    return bool(inputs.subject.moves)


def begins_with_mean(inputs: Inputs) -> bool:
    """Whether the first guess of the stress-free shape is the mean of two measured positions."""
    given = inputs.setting("mechanics.stress_free")
    return "mean_start" in (given["default"], f"{given['start']}_start")


def continues_standard(inputs: Inputs) -> bool:
    """Whether a strategy uses the standard's load path; with friction only one that is measured by it."""
    return "thickness_share" not in inputs.setting("load.strategy")["until"] or not inputs.has("friction")


def is_scattered(inputs: Inputs) -> bool:
    """Whether photons are scattered into the image."""
    return inputs.has("scatter")
