"""The stress-free shape that is loaded and pressed, and the moduli that carry the weight.

It is the one that the default method unloads to. Where that finds none, other methods are tried, and then
stiffer moduli, see mechanics.unloading_order; what is loaded and pressed after that has the same moduli.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pandas as pd

from mammosim.chain.graph import Inputs
from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.core.errors import ConfigurationError, MammosimError
from mammosim.core.mesh import TetMesh
from mammosim.core.settings import looked_up, require_positive
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import read_table, write_table
from mammosim.mechanics.body import Body, Skin
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading_order import Attempt, Order

ATTEMPT = ("method", "moduli_factor", "largest_mm", "outcome")


@dataclass(frozen=True)
class OrderSettings:
    """`mechanics.stress_free`: the method, those that are tried after it, and factors of all moduli."""

    default: str
    fallback: tuple[str, ...]
    moduli_factors: tuple[float, ...]
    iterations: int
    tolerance_mm: float

    def __post_init__(self) -> None:
        require_positive(self, "iterations", "tolerance_mm")

    @property
    def methods(self) -> tuple[str, ...]:
        """In their order."""
        return tuple(dict.fromkeys((self.default, *self.fallback)))


@dataclass(frozen=True)
class StressFree:
    """The body without gravity, and by what all moduli are multiplied that it may carry its weight.

    attempts: what was tried in its order, ATTEMPT and the moduli in kPa of each tissue; the last row is this
    shape's.
    """

    mesh: TetMesh
    moduli_factor: float = 1.0
    attempts: pd.DataFrame = field(default_factory=pd.DataFrame)


def stress_free(inputs: Inputs) -> StressFree:
    """By the default method, else by the first of others, with the softest moduli that carry the weight."""
    mesh: TetMesh = inputs["mesh"]
    body: Body = inputs["body"]
    gravity = inputs["breast"].gravity
    given = looked_up(OrderSettings, inputs.setting, "mechanics.stress_free")
    try:
        shape: TetMesh = inputs["unloaded"].mesh
    except ConfigurationError:
        raise
    except MammosimError as failure:
        limits = UnloadingSettings(given.tolerance_mm, given.iterations)
        known = [Attempt(given.default, 1.0, failure=failure)]
        found = Order(given.methods, given.moduli_factors, limits, known).unload(mesh, body, gravity=gravity)
        table = attempts_table(body, found.attempts)
        return StressFree(mesh.moved_to(found.points), found.attempts[-1].moduli_factor, table)
    return StressFree(shape, 1.0, attempts_table(body, (Attempt(given.default, 1.0),)))


def attempts_table(body: Body, attempts: tuple[Attempt, ...]) -> pd.DataFrame:
    """A row per attempt, in its order: ATTEMPT, and `{tissue}_kpa` of the body with its factor."""
    rows = []
    for each in attempts:
        outcome = CONVERGED if each.failure is None else unsolved(each.failure)
        rows.append(
            {"method": each.method, "moduli_factor": each.moduli_factor}
            | moduli_of(body.stiffened(each.moduli_factor))
            | {"largest_mm": each.largest_mm, "outcome": " ".join(outcome.split())}
        )
    return pd.DataFrame(rows)


def moduli_of(body: Body) -> dict[str, float]:
    """`{tissue}_kpa` of every tissue that a body has one modulus of."""
    solids = body.tissues.items() if isinstance(body.tissues, Mapping) else ()
    found = {f"{label.tissue}_kpa": tissue.youngs_modulus_kpa for label, tissue in solids}
    skins = [float(part.youngs_modulus_kpa) for part in body.parts if type(part) is Skin]
    return found | ({"skin_kpa": skins[0]} if skins else {})


def save_stress_free(found: StressFree, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The shape, and what was tried."""
    write_table(found.attempts.assign(**job)[[*job, *found.attempts.columns]], files["attempts"])
    write_mesh(found.mesh, files["shape"])


def load_stress_free(files: Mapping[str, str]) -> StressFree:
    """What save_stress_free wrote."""
    attempts = read_table(files["attempts"])
    return StressFree(read_mesh(files["shape"]), float(attempts.moduli_factor.iloc[-1]), attempts)
