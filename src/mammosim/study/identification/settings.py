"""What a fit is told: what is known before, the least errors of the data, how far to iterate, the grid."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Count, Limits, NotNegative, Positive, Settings
from mammosim.core.tissues import LARGEST_MODULUS_KPA
from mammosim.study.identification.moduli import KEYS, TISSUES

Modulus = Annotated[float, Limits(above=0, at_most=LARGEST_MODULUS_KPA, advice="was it given in Pa?")]
Factor = Annotated[float, Limits(above=1, advice="a standard deviation is a factor of 2 or so")]
PoissonRatio = Annotated[float, Limits(at_least=0, below=0.5)]


@dataclass(frozen=True)
class Prior(Settings):
    """What is known before: median_kpa and factor (a standard deviation is a factor of it) by tissue.

    poisson_ratio: mean and standard deviation; shift_mm, turn_deg: standard deviations of what registration
    leaves in each coordinate and about each axis.
    Raises ConfigurationError when a tissue is lacking or unknown, or a value is out of its limits.
    """

    median_kpa: Mapping[str, Modulus]
    factor: Mapping[str, Factor]
    poisson_ratio: tuple[PoissonRatio, Positive]
    shift_mm: Positive
    turn_deg: Positive

    def __post_init__(self) -> None:
        super().__post_init__()
        require_tissues("median_kpa", self.median_kpa, TISSUES)
        require_tissues("factor", self.factor, TISSUES)

    def widened(self, *, shift_mm: float, turn_deg: float) -> "Prior":
        """With no smaller standard deviations of what registration leaves; NaN where it states none."""
        shift, turn = float(np.fmax(self.shift_mm, shift_mm)), float(np.fmax(self.turn_deg, turn_deg))
        return replace(self, shift_mm=shift, turn_deg=turn)

    @property
    def mean(self) -> np.ndarray:
        """theta0 (15,), see study.identification.problem."""
        moduli = [np.log(self.median_kpa[tissue]) for _, tissue in KEYS]
        return np.array([*moduli, self.poisson_ratio[0], *[0.0] * 6])

    @property
    def deviation(self) -> np.ndarray:
        """s (15,)."""
        moduli = [np.log(self.factor[tissue]) for _, tissue in KEYS]
        return np.array([*moduli, self.poisson_ratio[1], *[self.shift_mm] * 3, *[self.turn_deg] * 3])


@dataclass(frozen=True)
class Errors(Settings):
    """Standard errors in mm: skin_mm of a distance, marker_mm of a coordinate of a marker.

    Raises ConfigurationError when one is not above 0.
    """

    skin_mm: Positive
    marker_mm: Positive


@dataclass(frozen=True)
class FitSettings(Settings):
    """tolerance: of the last step, in standard deviations of the posterior; largest_step: of ln E.

    stalled: a step up to so many standard deviations ends the fit, too, where it lowers Phi no more: nearest
    points change from one element to the next, and there Phi has kinks. It is added to the covariance.

    errors: the least that the data are taken to have; after iteration `settled` they stay as they are, since
    few data could trade their errors against each other for long; halvings: of a step that raises Phi.
    Raises ConfigurationError for a tolerance, step or number of iterations that is not above 0.
    """

    tolerance: Positive = 0.1
    stalled: NotNegative = 0.5
    max_iterations: Count = 15
    largest_step: Positive = 0.7
    halvings: int = 4
    settled: int = 3
    errors: Errors = field(default_factory=lambda: Errors(skin_mm=0.2, marker_mm=0.7))


@dataclass(frozen=True)
class Grid(Settings):
    """Moduli of the grid search: of fat and gland together, and of skin.

    Raises ConfigurationError when there is none, or one is no modulus.
    """

    breast_kpa: tuple[Modulus, ...]
    skin_kpa: tuple[Modulus, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("breast_kpa", "skin_kpa"):
            if not getattr(self, name):
                raise ConfigurationError(f"{name} is empty; write one modulus or more, as [0.5, 1.0, 2.0]")


@dataclass(frozen=True)
class Identification(Settings):
    """All of the key `identification` but its grid.

    model_error: standard deviation of ln E by tissue that the model itself adds, alike on both sides;
    draws: of the posterior, the fit itself among them; fascia_mm: the thickness that superficial fascia has.
    Raises ConfigurationError for an unknown tissue, or a value out of its limits.
    """

    prior: Prior
    errors: Errors
    model_error: Mapping[str, Positive]
    draws: Count
    fascia_mm: Annotated[float, Limits(above=0, at_most=10, advice="it has about 0.1 mm")]

    def __post_init__(self) -> None:
        super().__post_init__()
        require_tissues("model_error", self.model_error)


def require_tissues(place: str, given: Mapping[str, object], needed: tuple[str, ...] = ()) -> None:
    """Raise ConfigurationError for a tissue that a fit does not know, or one that is lacking."""
    if unknown := [name for name in given if name not in TISSUES]:
        raise ConfigurationError(f"{place} has no key {unknown[0]!r}; choose one of: {', '.join(TISSUES)}")
    if lacking := [name for name in needed if name not in given]:
        raise ConfigurationError(f"{place} lacks {', '.join(lacking)}; add it")
