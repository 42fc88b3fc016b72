"""What a user can ask of one breast, in the unit of its name, and how far two answers are apart in it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.chain.graph import Chain
from mammosim.core.errors import ConfigurationError

QUANTILE = 1.96  # of the normal distribution: 95 % lie within so many standard errors


@dataclass(frozen=True)
class Quantity:
    """products: what it is taken from; of: a chain -> its value; relative: whether changes are in percent.

    words: what it is, for tables and figures. column: what its value is called, with its unit, where that is
    not that of changes; beside: products that it is read with; size: 3 of a place.
    """

    words: str
    products: tuple[str, ...]
    of: Callable[[Chain], np.ndarray | float]
    relative: bool = False
    noise: Callable[[Chain], float] | None = None
    means_with: tuple[str, ...] = ()
    column: str = ""
    beside: tuple[str, ...] = ()
    size: int = 1

    def change(self, value: np.ndarray | float, reference: np.ndarray | float) -> float:
        """How far a value is from a reference, in the unit of the quantity's name."""
        away = float(np.linalg.norm(np.asarray(value) - reference))
        return 100 * away / float(np.linalg.norm(reference)) if self.relative else away


def _d_noise(chain: Chain) -> float:
    """From the 95 % interval of d'."""
    row = chain["mammogram"].row
    found: float = (row["calcification_d_high"] - row["calcification_d_low"]) / (
        2 * QUANTILE * row["calcification_d"]
    )
    return found


def _pressed(column: str) -> Callable[[Chain], float]:
    return lambda chain: float(chain["pressed"].row[column])


def _seen(column: str) -> Callable[[Chain], float]:
    return lambda chain: float(chain["mammogram"].row[column])


NOISE = ("quantum_noise",)  # a contrast over no noise is infinite
QUANTITIES: Mapping[str, Quantity] = {
    "nipple_mm": Quantity(
        "place of the nipple in the position",
        ("loaded",),
        lambda chain: nipple_of(chain, chain["loaded"].mesh.points),
        beside=("breast", "mesh"),
        size=3,
    ),
    "force_n": Quantity("force of the paddle", ("pressed",), _pressed("force_n")),
    "thickness_mm": Quantity("thickness under the paddle", ("pressed",), _pressed("thickness_mm")),
    "pressure_kpa": Quantity("mean pressure of the paddle", ("pressed",), _pressed("mean_pressure_kpa")),
    "strain_percent": Quantity(
        "95th percentile of the logarithmic strain",
        ("pressed",),
        _pressed("logarithmic_p95"),
        relative=True,
        column="strain",
    ),
    "mas_percent": Quantity(
        "automatic exposure",
        ("exposure",),
        lambda chain: chain["exposure"],
        relative=True,
        column="exposure_mas",
    ),
    "agd_percent": Quantity(
        "mean glandular dose at automatic exposure",
        ("exposed_dose",),
        lambda chain: chain["exposed_dose"].dose_mgy,
        relative=True,
        noise=lambda chain: chain["dose"].relative_error,
        column="agd_mgy",
        beside=("dose",),
    ),
    "scatter_to_primary": Quantity(
        "scatter over primary behind the lesion", ("mammogram",), _seen("scatter_to_primary")
    ),
    "cnr_percent": Quantity(
        "contrast-to-noise ratio of the lesion",
        ("mammogram",),
        _seen("cnr_quantum"),
        relative=True,
        means_with=NOISE,
        column="cnr",
    ),
    "d_percent": Quantity(
        "d' of the calcifications",
        ("mammogram",),
        _seen("calcification_d_expected"),
        relative=True,
        means_with=NOISE,
        column="d_prime",
    ),
    "d_estimated_percent": Quantity(
        "d' of the calcifications estimated from simulated images",
        ("mammogram",),
        _seen("calcification_d"),
        relative=True,
        noise=_d_noise,
        means_with=NOISE,
        column="d_prime_estimated",
    ),
    "slice_cnr_percent": Quantity(
        "contrast-to-noise ratio of the lesion in its slice",
        ("slices",),
        lambda chain: chain["slices"].cnr("sart"),
        relative=True,
        means_with=NOISE,
        column="slice_cnr",
    ),
}


def quantities(names: list[str]) -> Mapping[str, Quantity]:
    """Those with these names. Raises ConfigurationError for a name that means none."""
    if unknown := [name for name in names if name not in QUANTITIES]:
        raise ConfigurationError(f"no quantity {unknown[0]!r}; choose among: {', '.join(QUANTITIES)}")
    return {name: QUANTITIES[name] for name in names}


def nipple_of(chain: Chain, points: np.ndarray) -> np.ndarray:
    """Where a chain's nipple is (3,) mm when the nodes of its mesh are at points (n_node, 3)."""
    from mammosim.chain.points import MaterialPoints  # the workflow reads this table, and needs no more

    breast = chain["breast"]
    given = breast.to_reference(breast.nipple[None])
    mesh = chain["mesh"]
    found: np.ndarray = MaterialPoints.on(mesh, given).carry_above(given, mesh.points, points)[0]
    return found
