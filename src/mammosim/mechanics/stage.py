"""A compression: when it ends, how its steps are solved, and what each leaves."""

from dataclasses import dataclass, field, replace

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import Effect, MixedNeoHookean, NeoHookean, RigidPlate, SpringNetwork
from mammosim.mechanics.equilibrium import Settings
from mammosim.mechanics.friction_state import FrictionState
from mammosim.mechanics.newton import Iteration, NewtonSettings


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


# The default penalty in shear moduli of the bulk per mm (decisions/mechanics_contact.md).
PENALTY_RATIO = 30.0


@dataclass(frozen=True)
class PressSettings:
    """How a compression is solved.

    steps: how many equal ones to begin with, also the largest; smallest_step_mm: before it gives up;
    penetration_mm: how far skin that is pressed may be from the plate, on either side of its face, in the
    mean over a part of a face, at the end; path_penetration: the same in the steps before, relative to their
    length; with friction, which depends on the whole path, penetration_mm holds in all steps.
    penalty_kpa_per_mm: of the contact to begin with; None takes PENALTY_RATIO times the bulk's median shear
    modulus. parts: each skin face has six contact points in each of parts^2 triangles. friction_tolerance:
    of the lagged friction forces, relative. path_tolerance: of the free forces, relative, in all steps but
    the last, between rigid plates, which need no more. solver: by default without trusted
    steps, since contact opens and closes (decisions/mechanics_newton.md).
    """

    steps: int = 8
    smallest_step_mm: float = 0.2
    penetration_mm: float = 0.02
    path_penetration: float = 0.04
    penalty_kpa_per_mm: float | None = None
    parts: int = 2
    friction_tolerance: float = 1e-3
    path_tolerance: float = 1e-5
    solver: Settings = field(default_factory=lambda: Settings(newton=NewtonSettings(trusted=0, stagnation=8)))


@dataclass(frozen=True)
class Stage:
    """A body pressed to a thickness, with the unknowns q (m,) of the paddle.

    contacts: paddle and support; friction_states: of both, empty without friction; dissipated: by friction in
    all steps so far, uJ; history: of the Newton iterations of this step.
    """

    thickness: float
    q: np.ndarray
    x: np.ndarray
    contacts: tuple[RigidPlate, RigidPlate]
    friction_states: tuple[FrictionState, ...] = ()
    dissipated: float = 0.0
    history: tuple[Iteration, ...] = ()
    seconds: float = 0.0

    def augmented(self) -> "Stage":
        """The same stage, whose contacts have their pressures as multipliers."""
        paddle, support = (contact.augmented(self.x) for contact in self.contacts)
        return replace(self, contacts=(paddle, support))

    @property
    def gap_error(self) -> float:
        """How far skin that is pressed is from the plate that presses it at most, in the mean, mm."""
        return max(contact.gap_error(self.x) for contact in self.contacts)

    def meets_an_edge(self, within_mm: float) -> bool:
        """Whether skin meets the rounded edge of a plate, or will when it comes nearer by as much."""
        for contact in self.contacts:
            y, d = contact.at_points(self.x)
            across = np.abs(contact.obstacle.material(y[d < within_mm])[:, :2])
            if np.any(across > contact.obstacle.half_sizes[:2] - contact.obstacle.radius):
                return True
        return False

    def surroundings(self) -> tuple[Effect, ...]:
        """Contacts and friction, as they acted in this step."""
        return (
            *self.contacts,
            *(
                friction_state.effect(contact)
                for friction_state, contact in zip(self.friction_states, self.contacts)
            ),
        )


def default_penalty(effects: tuple[Effect, ...]) -> float:
    """PENALTY_RATIO times the median shear modulus of the cells, per mm."""
    bulk = (NeoHookean, MixedNeoHookean, SpringNetwork)
    mu = np.concatenate([effect.mu for effect in effects if isinstance(effect, bulk)])
    return PENALTY_RATIO * float(np.median(mu))
