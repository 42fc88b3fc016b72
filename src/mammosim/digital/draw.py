"""Digital volunteers drawn at random: a build between two women, and moduli of her own on either side."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mammosim.core.errors import ConfigurationError, EquilibriumError
from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.constitution import Constitution
from mammosim.digital.loading import load_truth
from mammosim.mechanics.equilibrium import Settings

BUILD = ("chest", "breast", "gland", "skin")
LARGEST_SEED = 2**31
# Where a loss of stability lies is not asked: a woman who needs steps below half the load reached is refused.
COARSE = Settings(smallest_step=0.5)

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Ranges:
    """Lowest and highest of what is drawn; every draw is uniform in the logarithm.

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
            if not 0 < low <= high:
                raise ConfigurationError(
                    f"{field.name} from {low:g} to {high:g}: give the lowest, above 0, and then the highest"
                )


def drawn_woman(ranges: Ranges, between: tuple[Values, Values], *, stream: tuple[str | int, ...]) -> Values:
    """The nested plain values {chest, breast, gland, skin, seed, moduli_kpa} of a woman, from a named stream.

    between: two builds; each length, angle and share of hers is drawn uniformly between theirs.
    """
    # ASSUME: the moduli of a made woman are independent of each other and of her build.
    rng = generator(*stream, "build")
    build = {
        part: {
            name: float(rng.uniform(*sorted(one[part][name] for one in between)))
            for name in sorted(between[0][part])
        }
        for part in BUILD
    }
    moduli = _moduli(ranges, generator(*stream, "moduli"))
    return {**build, "seed": int(rng.integers(LARGEST_SEED)), "moduli_kpa": moduli}


def _moduli(ranges: Ranges, rng: np.random.Generator) -> dict[str, dict[str, float]]:
    def drawn(low_and_high: tuple[float, float]) -> float:
        return float(np.exp(rng.uniform(*np.log(low_and_high))))

    adipose = drawn(ranges.adipose_kpa)
    middle = {
        "adipose": adipose,
        "glandular": adipose * drawn(ranges.glandular_per_adipose),
        "skin": drawn(ranges.skin_kpa),
        "muscle": drawn(ranges.muscle_kpa),
    }
    ratio = {name: drawn(ranges.right_per_left) for name in middle}
    return {
        "left": {name: E / np.sqrt(ratio[name]) for name, E in middle.items()},
        "right": {name: E * np.sqrt(ratio[name]) for name, E in middle.items()},
    }


def refusal(
    anatomy: Anatomy, mesh: TetMesh, made_of: Constitution, gravities: Mapping[str, np.ndarray]
) -> str:
    """Why a woman has no verified stable state in one of the positions, '' when she has one in each.

    gravities: unit vectors (3,) in the body frame, by position.
    """
    for position, gravity in gravities.items():
        try:
            load_truth(anatomy, mesh, gravity, made_of=made_of, settings=COARSE)
        except EquilibriumError as error:
            return f"{position}: {error}"
    return ""


def first_accepted(
    candidates: Iterable[Values], why_refused: Callable[[Values], str]
) -> tuple[Values, list[str]]:
    """The first candidate that is not refused, and why each one up to and with her was ('' for her).

    Raises ConfigurationError when all are refused.
    """
    reasons: list[str] = []
    for candidate in candidates:
        reasons.append(why_refused(candidate))
        if not reasons[-1]:
            return candidate, reasons
    raise ConfigurationError(
        f"each of {len(reasons)} draws was refused: {'; '.join(reasons)}; "
        "raise the lowest modulus of adipose tissue or skin, or allow more draws"
    )
