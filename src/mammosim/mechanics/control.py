"""When a compression ends: at a thickness, or at a force."""

from dataclasses import dataclass

from mammosim.core.errors import MechanicsError


@dataclass(frozen=True)
class Thickness:
    """Press until the plates are `mm` apart as the machine reads it. Raises MechanicsError for mm <= 0."""

    mm: float

    def __post_init__(self) -> None:
        if not self.mm > 0:
            raise MechanicsError(
                f"thickness {self.mm:g} mm is outside (0, ...), above it there is no contact"
            )


@dataclass(frozen=True)
class Force:
    """Press until the paddle feels `newton`, within the part `tolerance` of it, or fail at smallest_mm.

    Raises MechanicsError for values that are not above 0.
    """

    newton: float
    smallest_mm: float = 10.0
    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        if not (self.newton > 0 and self.smallest_mm > 0 and self.tolerance > 0):
            raise MechanicsError(
                f"force {self.newton:g} N, smallest thickness {self.smallest_mm:g} mm and tolerance "
                f"{self.tolerance:g} must be above 0; clinical forces are 50 to 200 N"
            )


Control = Thickness | Force
