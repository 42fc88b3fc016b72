"""What a published model does otherwise than the study: its law, its ribs, its stress-free shape."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.graph import Inputs
from mammosim.chain.published_stages import (
    AS_MEASURED,
    CHEST_WALL,
    INCREMENTS,
    NETWORK,
    SLIDING,
)
from mammosim.chain.strategies import LoadPath, PressSetup
from mammosim.chain.stress_free import StressFree
from mammosim.chain.unloaded import HISTORY, LoadedShape, UnloadedShape
from mammosim.chain.unloaded import body as study_body
from mammosim.core.mesh import TetMesh
from mammosim.core.positions import gravity_direction
from mammosim.core.settings import NotNegative, Positive, read
from mammosim.mechanics.body import Body, ChestWall, Part, Slides
from mammosim.mechanics.effects import Buoyancy
from mammosim.mechanics.equilibrium import Settings, equilibrium
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.other_laws import (
    IncrementalBody,
    as_network,
    in_increments,
    pressed_in_increments,
)
from mammosim.mechanics.ribs import ribs_of
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading import METHODS


@dataclass(frozen=True)
class SlidingSettings:
    """`effects.sliding`: stiffness against leaving the ribs, and of the loose tissue along them, kPa/mm."""

    normal_kpa_per_mm: Positive
    tangential_kpa_per_mm: NotNegative


@dataclass(frozen=True)
class ChestWallSettings:
    """`effects.chest_wall`: penalty of the skin's contact with the ribs, kPa/mm."""

    penalty_kpa_per_mm: Positive


@dataclass(frozen=True)
class WaterSettings:
    """`effects.water`: its density, and how far before the foremost rib its surface is in prone."""

    density_g_cm3: Positive
    before_ribs_mm: float


def body(inputs: Inputs) -> Body:
    """The tissues, skin, fascia and ligaments of the study's, on the ribs and by the law of the model."""
    made = study_body(inputs)
    made = replace(made, parts=(*made.parts, *_on_ribs(inputs)))
    law = inputs.setting("model.law")
    if law == INCREMENTS:
        breast: Breast = inputs["breast"]
        free = inputs.setting("mechanics.stress_free.default") == AS_MEASURED
        return in_increments(made, inputs.setting("model.increments"), breast.gravity if free else None)
    return as_network(made) if law == NETWORK else made


def _on_ribs(inputs: Inputs) -> tuple[Part, ...]:
    """Its parts that need the ribs of the measured breast."""
    if not (inputs.has(SLIDING) or inputs.has(CHEST_WALL)):
        return ()
    ribs = ribs_of(inputs["mesh"])
    parts: list[Part] = []
    if inputs.has(SLIDING):
        sliding = read(SlidingSettings, inputs.setting("effects.sliding"), "effects.sliding")
        parts.append(Slides(ribs.faces, ribs.wall, **vars(sliding)))
    if inputs.has(CHEST_WALL):
        wall = read(ChestWallSettings, inputs.setting("effects.chest_wall"), "effects.chest_wall")
        parts.append(ChestWall(ribs.wall, **vars(wall)))
    return tuple(parts)


def unloaded(inputs: Inputs) -> UnloadedShape:
    """The measured shape itself, or the one that the breast would have in water."""
    mesh: TetMesh = inputs["mesh"]
    no_history = pd.DataFrame(columns=HISTORY)
    if inputs.setting("mechanics.stress_free.default") == AS_MEASURED:
        return UnloadedShape(mesh, no_history)
    water = read(WaterSettings, inputs.setting("effects.water"), "effects.water")
    return UnloadedShape(mesh.moved_to(_in_water(inputs, mesh, water)), no_history)


# ASSUME: nobody measured the breast in water: the shape there is computed, from that without gravity.
def _in_water(inputs: Inputs, mesh: TetMesh, water: WaterSettings) -> np.ndarray:
    """Points (n_node, 3) mm of the breast that hangs in water, whose surface is near the foremost rib."""
    of_body: Body = inputs["body"]
    breast: Breast = inputs["breast"]
    given = "mechanics.stress_free"
    limits = UnloadingSettings(
        *(inputs.setting(f"{given}.{name}") for name in ("tolerance_mm", "iterations"))
    )
    rest = mesh.moved_to(METHODS["inverse"](mesh, of_body, gravity=breast.gravity, settings=limits).points)
    depth = mesh.points[mesh.boundary_nodes("posterior")] @ breast.gravity
    level = float(depth.max()) + water.before_ribs_mm
    buoyancy = Buoyancy.of(rest, breast.gravity, level_mm=level, density_g_cm3=water.density_g_cm3)
    weight = of_body.weight(rest, breast.gravity)
    effects, held = of_body.effects(rest), of_body.held(rest)
    return equilibrium(rest, effects, loads=(weight, buoyancy), held=held).points


def stress_free(inputs: Inputs) -> StressFree:
    """The shape that its method unloads to."""
    return StressFree(inputs["unloaded"].mesh)


def loaded(inputs: Inputs) -> LoadedShape:
    """The body in the position of the load, in which gravity is the scan's where it was measured in it."""
    breast: Breast = inputs["breast"]
    of_body: Body = inputs["body"]
    rest: TetMesh = inputs["stress_free"].mesh
    newton = NewtonSettings(tolerance=inputs.setting("mechanics.newton_tolerance"))
    position = inputs.setting("load.position")
    measured = position == inputs.setting("model.position")
    gravity = breast.gravity if measured else gravity_direction(position)
    return LoadedShape(rest.moved_to(of_body.load(rest, gravity, settings=Settings(newton=newton)).points))


def pressed_body(inputs: Inputs) -> Body:
    """The body between the plates: the same."""
    found: Body = inputs["body"]
    return found


@dataclass(frozen=True)
class Squeezed:
    """What the paddle feels at the distance of the plates to which the breast is pressed."""

    thickness_mm: float
    force_n: float


def force(inputs: Inputs) -> Squeezed:
    """Between rigid plates, by the load path of the standard strategy or in the increments of the law."""
    setup: PressSetup = inputs["press_setup"]
    of_body: Body = inputs["body"]
    if isinstance(of_body, IncrementalBody):
        rows = pressed_in_increments(
            setup.mesh, of_body, plates=setup.plates, thickness_mm=setup.thickness_mm
        )
        last = rows.iloc[-1]
        return Squeezed(float(last.thickness_mm), float(last.force_n))
    path: LoadPath = inputs["standard_path"]
    last = path.path.iloc[-1]
    return Squeezed(float(last.readout_mm), float(last.force_n))
