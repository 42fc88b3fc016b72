"""Mechanical products of a chain: mesh, stress-free shape, the shape in a position, the pressed breast.

Effects: gland and muscle (stiffer than fat), skin, fascia, ligaments; between plates also weight and
friction.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from mammosim.chain.breast import Breast, scanned_mesh
from mammosim.chain.graph import Chain, Inputs, Product
from mammosim.chain.plates import craniocaudal_plates
from mammosim.chain.points import MaterialPoints
from mammosim.chain.pressed import Pressed, pressed
from mammosim.chain.strategies import Scene, Strategy, ThicknessShare, Way
from mammosim.core.mesh import TetMesh
from mammosim.core.positions import gravity_direction
from mammosim.core.tissues import tissues_by_label
from mammosim.mechanics.body import Body, Fascia, Ligaments, Part, Skin
from mammosim.mechanics.equilibrium import Settings
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.paddles import Friction, Rigid
from mammosim.mechanics.stage import PressSettings
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading import METHODS

# ASSUME: a woman stands while her breast is pressed.
STANDING = "upright"


def _mesh(inputs: Inputs) -> TetMesh:
    """The body, common frame."""
    breast: Breast = inputs.subject
    mesh = scanned_mesh(breast.labels, breast.fiducials.of_kind("chest"), inputs.setting("mesh"))
    return mesh.moved_to(np.ascontiguousarray(breast.to_reference(mesh.points)))


def _body(inputs: Inputs) -> Body:
    """What it is made of. A stiffer tissue whose effect is absent is as stiff as fat."""
    tissues = {name: {**values} for name, values in inputs.setting("tissues.tissues").items()}
    for effect, tissue in (("gland", "glandular"), ("muscle", "muscle")):
        if not inputs.has(effect):
            tissues[tissue]["youngs_modulus_kpa"] = tissues["adipose"]["youngs_modulus_kpa"]
    parts: Mapping[str, Callable[[], Part]] = {
        "skin": lambda: Skin(**inputs.setting("tissues.skin")),
        # ASSUME: superficial fascia lies right under the skin.
        "fascia": lambda: Fascia(**inputs.setting("effects.fascia"), boundary="skin"),
        "ligaments": lambda: Ligaments(**inputs.setting("effects.ligaments")),
    }
    return Body(tissues_by_label(tissues), tuple(part() for name, part in parts.items() if inputs.has(name)))


def _stress_free(inputs: Inputs) -> TetMesh:
    """The body without gravity."""
    mesh, given = inputs["mesh"], inputs.setting("mechanics.stress_free")
    found = METHODS[given["default"]](
        mesh,
        inputs["body"],
        gravity=inputs.subject.gravity,
        settings=UnloadingSettings(given["tolerance_mm"], given["iterations"]),
    )
    return mesh.moved_to(found.points)


def _loaded(inputs: Inputs) -> np.ndarray:
    """Points (n_node, 3) mm of the body in the position of the scene."""
    newton = NewtonSettings(tolerance=inputs.setting("mechanics.newton_tolerance"))
    gravity = gravity_direction(inputs.setting("load.position"))
    settings = Settings(newton=newton)
    return inputs["body"].load(inputs["stress_free"], gravity, settings=settings).points


def _scene(inputs: Inputs) -> Scene:
    """The stress-free breast before the plates."""
    mesh, body = inputs["stress_free"], inputs["body"]
    given = {name: inputs.setting(f"compression.{name}") for name in PRESS}
    breast: Breast = inputs.subject
    nipple = MaterialPoints.on(inputs["mesh"], breast.to_reference(breast.nipple[None])).carry(mesh.points)[0]
    plates = craniocaudal_plates(mesh, nipple, plate_mm=given["plate_mm"], chest_gap_mm=given["chest_gap_mm"])
    effects = body.effects(mesh)
    if inputs.has("weight"):
        effects += (body.weight(mesh, gravity_direction(STANDING)),)
    if inputs.has("friction"):
        plates = replace(plates, friction=Friction(**inputs.setting("effects.friction")))
    return Scene(
        mesh,
        effects,
        plates,
        moduli="gravity",
        thickness_mm=inputs.setting("load.thickness_mm"),
        smallest_mm=given["smallest_mm"],
        solved=PressSettings(steps=given["steps"], penetration_mm=given["penetration_mm"]),
    )


def _standard(inputs: Inputs) -> Way:
    """The way of the standard strategy, which others are measured by."""
    return Way.of(ThicknessShare(1.0).press(inputs["scene"], Rigid()))


def _pressed(inputs: Inputs) -> Pressed:
    """The breast between the plates, where the strategy of the scene ends."""
    strategy, scene = Strategy.of(inputs.setting("load.strategy")), inputs["scene"]
    if not isinstance(strategy.until, ThicknessShare) or strategy.paddle != Rigid():
        scene = replace(scene, standard=inputs["standard"])
    return pressed(scene, strategy.press(scene), inputs.setting("compression.thresholds"))


MATERIAL = ("gland", "muscle", "skin", "fascia", "ligaments")
PLATES = ("weight", "friction")
PRESS = ("plate_mm", "chest_gap_mm", "smallest_mm", "steps", "penetration_mm")  # of the configuration
PRODUCTS: Mapping[str, Product] = {
    "mesh": Product(_mesh, reads=("mesh",)),
    "body": Product(_body, reads=("tissues", "effects.fascia", "effects.ligaments"), effects=MATERIAL),
    "stress_free": Product(_stress_free, ("mesh", "body"), ("mechanics.stress_free",)),
    "loaded": Product(_loaded, ("body", "stress_free"), ("mechanics.newton_tolerance", "load.position")),
    "scene": Product(
        _scene,
        ("mesh", "body", "stress_free"),
        (*(f"compression.{name}" for name in PRESS), "effects.friction", "load.thickness_mm"),
        PLATES,
    ),
    "standard": Product(_standard, ("scene",)),
    "pressed": Product(_pressed, ("scene", "standard"), ("load.strategy", "compression.thresholds")),
}


def nipple_of(chain: Chain, points: np.ndarray) -> np.ndarray:
    """Where a chain's nipple is (3,) mm when the nodes of its mesh are at points (n_node, 3)."""
    breast: Breast = chain.subject
    given = breast.to_reference(breast.nipple[None])
    mesh = chain["mesh"]
    return MaterialPoints.on(mesh, given).carry_above(given, mesh.points, points)[0]
