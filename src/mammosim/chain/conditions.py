"""When a stage needs one of its products: decided by its own settings and effects."""

from mammosim.chain.graph import Inputs

MEASURED_BY_IT = {"force_share", "pressure_kpa"}


def is_moved(inputs: Inputs) -> bool:
    """Whether the measured position is moved into the frame of another one."""
    return bool(inputs.subject.moves)


def begins_with_mean(inputs: Inputs) -> bool:
    """Whether the first guess of the stress-free shape is the mean of two measured positions."""
    method, start = (inputs.setting(f"mechanics.stress_free.{name}") for name in ("default", "start"))
    return "mean_start" in (method, f"{start}_start")


def continues_standard(inputs: Inputs) -> bool:
    """Whether a strategy uses the standard's load path; with friction only one measured by it does."""
    return bool(MEASURED_BY_IT & set(inputs.setting("load.strategy")["until"])) or not inputs.has("friction")


def is_scattered(inputs: Inputs) -> bool:
    """Whether photons are scattered into the image."""
    return inputs.has("scatter")
