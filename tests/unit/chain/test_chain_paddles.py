"""Plates by description: what a strategy may say of them, and what becomes of the breast between them."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
import yaml

from mammosim.chain.conditions import YIELDING, is_flat, is_standard
from mammosim.chain.configuration import check_settings
from mammosim.chain.paddles import PARTS, YIELDS, Plate, known_by_content
from mammosim.chain.plates import PlateSize
from mammosim.chain.press import pressed_breast
from mammosim.chain.strategies import LoadPath, PressSetup, Strategy
from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.io.surfaces import digest_of
from mammosim.mechanics.body import Body
from mammosim.mechanics.described import Described, Size, Sloped
from mammosim.mechanics.effects import Cushion
from mammosim.mechanics.paddles import Plates, Rigid, Tilting
from mammosim.mechanics.plate_shapes import Curved, Function

THRESHOLDS = {"logarithmic": [0.0], "pressure_kpa": [0.0]}
AXES = np.column_stack([[0.0, -1, 0], [1.0, 0, 0], [0.0, 0, 1]])
UNTIL = {"thickness_share": 1.0}
SLOPE, DOME = {"sloped": {"angle_deg": 2.0}}, {"curved": {"across_radius_mm": 60.0}}
CUSHION = {"cushion": {"thickness_mm": 6.0, "youngs_modulus_kpa": 3.0}}


@pytest.fixture(scope="module")
def setup(block) -> PressSetup:
    """A cube of 30 mm, held behind, under plates that reach over its front 20 mm."""
    mesh, tissue = block(2), Tissue(1.0, 0.45, 1.0)
    plates = Plates(np.array([15.0, 0.0, 15.0]), AXES, np.array([20.0, 25.0, 6.0]), 5.0)
    return PressSetup(mesh, Body({Label.ADIPOSE: tissue}).effects(mesh), plates, "gravity", 24.0, 8.0)


@pytest.fixture(scope="module")
def standard(setup):
    found = Strategy.read({"until": UNTIL}).press(setup)
    return replace(setup, standard=LoadPath.of(setup.mesh, found))


def pressed(setup, **plates):
    strategy = Strategy.read({"until": UNTIL, **plates})
    return pressed_breast(setup, strategy.press(setup), THRESHOLDS)


def test_a_strategy_describes_both_plates_by_parts():
    size = {"width_mm": 40, "edge_radius_mm": 3}
    found = Strategy.read(
        {
            "paddle": {"tilting": {"stiffness_n_mm_per_rad": 50}, **SLOPE, **DOME, "size": size, **CUSHION},
            "support": {"function": {"rise_mm": "across**2 / 100"}, **SLOPE},
            "until": UNTIL,
        }
    )
    assert found.paddle == Described(
        Tilting(50.0), Sloped(2.0), (Curved(across_radius_mm=60.0),), Size(width_mm=40.0, edge_radius_mm=3.0)
    )
    assert found.support == Described(Rigid(), Sloped(2.0), (Function("across**2 / 100"),))
    assert found.cushions == (Cushion(6.0, 3.0), None)


def test_a_paddle_that_only_yields_is_what_it_was():
    hinge = {"tilting": {"stiffness_n_mm_per_rad": 50}}
    assert Strategy.read({"paddle": hinge, "until": UNTIL}) == Strategy(
        Tilting(50.0), Strategy.read({"until": UNTIL}).until
    )
    assert Plate.read({}, at="paddle") == Plate(Rigid(), None)


def test_what_a_strategy_may_say_is_in_the_registry_and_in_the_schema(repository):
    schema = yaml.safe_load((repository / "workflow/schemas/compression.schema.yaml").read_text())
    (strategy,) = schema["patternProperties"].values()
    assert set(strategy["properties"]["paddle"]["properties"]) == set(PARTS)
    assert set(strategy["properties"]["support"]["properties"]) == set(PARTS) - set(YIELDS)
    assert tuple(YIELDS) == YIELDING
    plates = {"paddle": {**SLOPE, **DOME, **CUSHION}, "support": {"curved": {"outward_radius_mm": -90}}}
    check_settings({"standard": {"until": UNTIL}, "mine": {"until": UNTIL, **plates}}, schema, files=["-"])


@pytest.mark.parametrize(
    ("strategy", "standard", "flat"),
    [
        ({"until": UNTIL}, True, True),
        ({"until": {"force_n": 5}}, False, True),
        ({"until": UNTIL, "paddle": {"flexible": {}}}, False, True),
        ({"until": UNTIL, "paddle": {"flexible": {}, "sloped": {}}}, False, False),
        ({"until": UNTIL, "support": DOME}, False, False),
    ],
)
def test_only_flat_plates_continue_the_path_of_the_standard(strategy, standard, flat):
    assert is_standard(strategy) is standard
    assert is_flat(strategy) is flat


@pytest.mark.parametrize(
    ("plates", "words"),
    [
        ({"paddle": {"sopt": {}}}, r"^mine\.paddle = {'sopt': {}}; 'sopt' is unknown, give one or more"),
        ({"paddle": {"sloped": {}}}, r"^mine\.paddle\.sloped lacks angle_deg"),
        ({"paddle": {"curved": {"radius": 3}}}, r"^mine\.paddle\.curved has no key 'radius'; choose"),
        ({"paddle": {"curved": {}}}, r"^mine\.paddle\.curved: a face of radii None mm outward"),
        ({"paddle": {"surface": {"file": "no.stl"}}}, r"^mine\.paddle\.surface: no surface no\.stl"),
        ({"paddle": {"function": {"rise_mm": "x"}}}, r"^mine\.paddle\.function: 'x' is not understood"),
        ({"paddle": {"cushion": {"thickness_mm": 5}}}, r"^mine\.paddle\.cushion lacks youngs_modulus_kpa"),
        (
            {"paddle": {name: {"stiffness_n_mm_per_rad": 5} for name in YIELDS}},
            r"^mine\.paddle is both tilting and flexible; a paddle yields in one way",
        ),
        (
            {"support": {"tilting": {"stiffness_n_mm_per_rad": 5}}},
            r"^mine\.support = {'tilting': .*}: a support does not yield, only a paddle",
        ),
    ],
)  # fmt: skip
def test_a_plate_that_cannot_be_built_is_rejected_with_its_place(plates, words):
    with pytest.raises(ConfigurationError, match=words):
        Strategy.read({"until": UNTIL, **plates}, at="mine")


def test_plates_that_cannot_be_are_rejected_by_the_size_of_the_study():
    size = PlateSize(width=160.0, depth=110.0, height=20.0, edge_radius=8.0)
    hollow = {"curved": {"across_radius_mm": -100.0}}
    with pytest.raises(
        ConfigurationError, match=r"^mine: a face of across_radius_mm = -100 would be steeper"
    ):
        Strategy.read({"until": UNTIL, "support": hollow}).require_possible(size, at="mine")
    Strategy.read({"until": UNTIL, "support": {"curved": {"across_radius_mm": -120.0}}}).require_possible(
        size
    )


def test_a_surface_is_known_by_the_content_of_its_file(tmp_path):
    u, v = np.array([0.0, 40, 40, 0]), np.array([0.0, 0, 50, 50])
    points = np.concatenate([np.stack([u, v, 0 * u + z], axis=1) for z in (0.0, 10.0)])
    squares = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    triangles = np.concatenate([np.array(squares)[:, [0, 1, 2]], np.array(squares)[:, [0, 2, 3]]])
    meshio.stl.write(tmp_path / "slab.stl", meshio.Mesh(points, [("triangle", triangles)]))
    given = {"until": UNTIL, "paddle": {"surface": {"file": "slab.stl"}, **SLOPE}}
    found = known_by_content(given, lambda name: str(tmp_path / name), at="mine")
    file = str(tmp_path / "slab.stl")
    assert found["paddle"]["surface"] == {"file": file, "digest": digest_of(file)}
    paddle = Strategy.read(found).paddle
    assert isinstance(paddle, Described)
    assert (paddle.size.depth_mm, paddle.size.width_mm) == (40.0, 50.0)
    with pytest.raises(
        ConfigurationError, match=r"^mine\.paddle\.surface: no file slab\.stl; correct the path"
    ):
        known_by_content(given, lambda name: str(tmp_path / "elsewhere" / name), at="mine")


@pytest.mark.parametrize("plates", [{"paddle": SLOPE}, {"paddle": CUSHION}, {"support": DOME}])
def test_described_plates_are_pressed_from_first_contact(standard, plates):
    made = pressed(standard, **plates)
    assert made.path.readout_mm.iloc[0] > 24.0 + 5.0
    assert made.path.work_uj.iloc[-1] == pytest.approx(made.path.energy_uj.iloc[-1], rel=0.1)
    assert made.row["plates_mm"] == 24.0


def test_the_voxels_reach_as_far_as_shaped_plates_and_cushions_let_the_breast(standard):
    """A hollow support and a sloped paddle: the breast is thicker than what the machine reads."""
    flat = pressed(standard)
    low, high = flat.plates["support_z_mm"], flat.plates["paddle_z_mm"]
    made = pressed(standard, paddle=SLOPE, support={"curved": {"across_radius_mm": 90.0}})
    skin = made.mesh.points[made.mesh.boundary_nodes("skin")]
    before = skin[skin[:, 1] < made.plates["chest_y_mm"], 2]
    assert made.plates["support_z_mm"] < low - 0.5
    assert made.plates["paddle_z_mm"] > high + 0.5
    # Skin lies on the plates on average; single points of these faces are up to 0.2 mm inside.
    assert before.min() > made.plates["support_z_mm"] - 0.25
    assert before.max() < made.plates["paddle_z_mm"] + 0.25
    assert made.row["thickness_max_mm"] > made.row["thickness_min_mm"] + 0.3
    soft = pressed(standard, paddle=CUSHION)
    skin = soft.mesh.points[soft.mesh.boundary_nodes("skin")]
    before = skin[skin[:, 1] < soft.plates["chest_y_mm"], 2]
    assert before.max() > high + 0.3
    assert before.max() < soft.plates["paddle_z_mm"] + 0.25
    assert soft.row["thickness_mm"] > 24.2


def test_beside_a_small_paddle_the_breast_is_seen_too(standard):
    small = {"size": {"width_mm": 16.0, "depth_mm": 16.0, "edge_radius_mm": 2.0}}
    made = pressed(standard, paddle=small)
    skin = made.mesh.points[made.mesh.boundary_nodes("skin")]
    before = skin[skin[:, 1] < made.plates["chest_y_mm"], 2]
    assert before.max() > made.plates["support_z_mm"] + 24.0 + 1.0
    assert before.max() <= made.plates["paddle_z_mm"]


def test_a_mean_pressure_is_met_on_the_path_of_the_plates_themselves(standard):
    alone = pressed(standard, paddle=DOME)
    goal = 0.7 * alone.row["mean_pressure_kpa"]
    found = Strategy.read({"until": {"pressure_kpa": {"gravity": goal}}, "paddle": DOME}).press(
        replace(standard, smallest_mm=22.0)
    )
    assert found.path.mean_pressure_kpa.iloc[-1] >= 0.98 * goal
    assert found.path.readout_mm.iloc[-1] > 24.0
