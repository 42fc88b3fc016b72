"""Virtual patients sampled at random: a build between two others, and moduli of her own on either side."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields

import numpy as np

from mammosim.core.errors import ConfigurationError, EquilibriumError
from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.settings import annotations
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.constitution import Constitution
from mammosim.digital.loading import load_truth
from mammosim.digital.patient import Breast, Chest, Gland, Moduli, SideModuli, SkinLayer, VirtualPatient
from mammosim.mechanics.equilibrium import Settings

LARGEST_SEED = 2**31
# The load at which stability is lost need not be known: a sampled patient who needs steps below half the load
# that was reached is given up.
COARSE = Settings(smallest_step=0.5)


@dataclass(frozen=True)
class Ranges:
    """Lowest and highest of what is sampled; every sample is uniform in the logarithm.

    adipose_kpa, skin_kpa, muscle_kpa: geometric mean of both sides; glandular_per_adipose: ratio of two such;
    right_per_left: ratio of the two moduli of each tissue. Raises ConfigurationError unless 0 < low <= high.
    """

    adipose_kpa: tuple[float, float]
    glandular_per_adipose: tuple[float, float]
    skin_kpa: tuple[float, float]
    muscle_kpa: tuple[float, float]
    right_per_left: tuple[float, float]

    def __post_init__(self) -> None:
        for field in fields(self):
            low, high = getattr(self, field.name)
            if not 0 < low <= high < np.inf:
                raise ConfigurationError(
                    f"{field.name} from {low:g} to {high:g}: give the lowest, above 0, and then the highest"
                )


def sampled_patient(
    ranges: Ranges, between: tuple[VirtualPatient, VirtualPatient], *, stream: tuple[str | int, ...]
) -> VirtualPatient:
    """A virtual patient from a named random stream.

    between: two builds; each length, angle and share of hers is sampled uniformly between theirs.
    """
    # ASSUME: the moduli of a sampled patient are independent of each other and of her build.
    rng = generator(*stream, "build")

    def sampled(kind: type, part: str) -> dict[str, float]:
        ends = [getattr(patient, part) for patient in between]
        return {
            name: float(rng.uniform(*sorted(getattr(end, name) for end in ends)))
            for name in sorted(annotations(kind))
        }

    return VirtualPatient(
        chest=Chest(**sampled(Chest, "chest")),
        breast=Breast(**sampled(Breast, "breast")),
        gland=Gland(**sampled(Gland, "gland")),
        skin=SkinLayer(**sampled(SkinLayer, "skin")),
        moduli_kpa=_moduli(ranges, generator(*stream, "moduli")),
        seed=int(rng.integers(LARGEST_SEED)),
    )


def _moduli(ranges: Ranges, rng: np.random.Generator) -> Moduli:
    def sampled(low_and_high: tuple[float, float]) -> float:
        return float(np.exp(rng.uniform(*np.log(low_and_high))))

    adipose = sampled(ranges.adipose_kpa)
    middle = {
        "adipose": adipose,
        "glandular": adipose * sampled(ranges.glandular_per_adipose),
        "skin": sampled(ranges.skin_kpa),
        "muscle": sampled(ranges.muscle_kpa),
    }
    ratio = {name: sampled(ranges.right_per_left) for name in middle}
    return Moduli(
        left=SideModuli(**{name: float(E / np.sqrt(ratio[name])) for name, E in middle.items()}),
        right=SideModuli(**{name: float(E * np.sqrt(ratio[name])) for name, E in middle.items()}),
    )


def failure(
    anatomy: Anatomy, mesh: TetMesh, constitution: Constitution, gravities: Mapping[str, np.ndarray]
) -> str:
    """The first position without a verified stable state and why there is none; '' where each has one.

    gravities: unit vectors (3,) in the body frame, by position.
    """
    for position, gravity in gravities.items():
        try:
            load_truth(anatomy, mesh, gravity, constitution=constitution, settings=COARSE)
        except EquilibriumError as error:
            return f"{position}: {error}"
    return ""


def first_stable(
    candidates: Iterable[VirtualPatient], failure_of: Callable[[VirtualPatient], str]
) -> tuple[VirtualPatient, list[str]]:
    """The first candidate without a failure, and that of each one up to and with her ('' for her).

    Raises ConfigurationError when all fail.
    """
    failures: list[str] = []
    for candidate in candidates:
        failures.append(failure_of(candidate))
        if not failures[-1]:
            return candidate, failures
    raise ConfigurationError(
        f"each of {len(failures)} sampled patients failed: {'; '.join(failures)}; "
        "raise the lowest modulus of adipose tissue or skin, or allow more draws"
    )
