"""Laws of published models: linear elasticity in increments, networks of springs; and what lies on ribs."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from mechanics_bodies import box, cylinder, nearest, sphere_part
from mechanics_derivatives import gradient

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import SUBTETRAHEDRA, TetMesh
from mammosim.core.rigid import rotation
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body, ChestWall, Slides
from mammosim.mechanics.effects import EllipticCylinder, NeoHookean, SmallStrain, SpringNetwork
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.other_laws import IncrementalBody, as_network, pressed_in_increments
from mammosim.mechanics.paddles import Plates
from mammosim.mechanics.ribs import ribs_of

DOWN = np.array([0.0, 0.0, -1.0])
UP = -DOWN


def tissue(E=1.0, nu=0.45, density=1.0):
    return {Label.ADIPOSE: Tissue(E, nu, density)}


@pytest.fixture(scope="module")
def block():
    """30 x 30 x 20 mm, held at z = 0."""
    return box((3, 3, 2), (30.0, 30.0, 20.0))


def test_at_small_strain_linear_elasticity_is_what_the_hyperelastic_law_becomes(block):
    """Their forces differ by the square of the displacement."""
    u = 1e-5 * np.sin(block.points / 7.0)[:, [1, 2, 0]] * 10.0
    linear, law = SmallStrain.of(block, tissue()), NeoHookean.of(block, tissue())
    for part in (1.0, 0.1):
        g = gradient(law, block.points + part * u)
        assert gradient(linear, block.points + part * u) == pytest.approx(
            g, abs=10 * part * 1e-5 * np.abs(g).max()
        )


def test_linear_elasticity_is_exact_in_uniform_strain(block):
    """W V with W = mu e:e + lambda/2 (tr e)^2, at any size of the strain."""
    e = np.diag([0.3, -0.1, 0.2])
    of = SmallStrain.of(block, tissue())
    mu, lame = float(of.mu[0]), float(of.lame[0])
    W = mu * np.sum(e**2) + lame / 2 * np.trace(e) ** 2
    assert of.energy(block.points @ (np.eye(3) + e)) == pytest.approx(W * 30 * 30 * 20, rel=1e-12)


@dataclass(frozen=True)
class FreeBelow(IncrementalBody):
    """Held against rigid motion alone, so that plates press it uniformly."""

    def held(self, mesh):
        held = np.zeros(mesh.points.shape, bool)
        middle = nearest(mesh, [15.0, 15.0, 10.0])
        held[middle] = True
        held[nearest(mesh, [30.0, 15.0, 10.0]), 1:] = True
        return held


@pytest.fixture
def between(block):
    """The block with skin all around it, and plates that meet it at 20 mm."""
    all_around = np.vstack([*block.boundaries.values()])
    free = replace(block, boundaries={"skin": all_around, "posterior": block.boundaries["posterior"]})
    plates = Plates.covering(free.points, direction=UP, outward=np.array([1.0, 0.0, 0.0]))
    plates = replace(plates, centre=np.array([15.0, 15.0, 10.0]), half_sizes=np.array([80.0, 80.0, 10.0]))
    return free, plates


@pytest.mark.parametrize("increments", [1, 3])
def test_plates_close_in_even_increments_and_hardly_sink_in(between, increments):
    free, plates = between
    body = FreeBelow(tissue(2.0, 0.25), increments=increments)
    rows = pressed_in_increments(free, body, plates=plates, thickness_mm=18.5)
    assert rows.thickness_mm.tolist() == pytest.approx(np.linspace(20.0, 18.5, increments + 1)[1:])
    assert (rows.penetration_mm < 0.1).all()
    stiff = FreeBelow(tissue(200.0, 0.25), increments=increments)
    as_far = pressed_in_increments(free, stiff, plates=plates, thickness_mm=18.5).penetration_mm
    assert as_far.tolist() == pytest.approx(rows.penetration_mm.tolist(), rel=1e-2), "whatever the modulus"
    with pytest.raises(
        MechanicsError, match=r"thickness 20 mm is not below 20\.0 mm, where the plates first"
    ):
        pressed_in_increments(free, body, plates=plates, thickness_mm=20.0)


def test_plates_press_a_block_by_the_integral_of_its_increments(between):
    """dF = E A dl / l, A = A0 (l0 / l)^(2 nu): F = E A0 / (2 nu) ((l0 / l)^(2 nu) - 1)."""
    E, nu, l0, l = 2.0, 0.25, 20.0, 14.0
    free, plates = between
    rows = pressed_in_increments(free, FreeBelow(tissue(E, nu), increments=60), plates=plates, thickness_mm=l)
    force_n = E * 900.0 / (2 * nu) * ((l0 / l) ** (2 * nu) - 1) / 1e3
    # Forward increments of 0.1 mm: half a step of dF/dl; contact of 1 % of a step.
    assert rows.force_n.iloc[-1] == pytest.approx(force_n, rel=0.02)
    assert rows.force_n.is_monotonic_increasing


def test_increments_of_a_load_converge_in_their_number(block):
    """Forward integration: the change halves with the increments."""
    ends = [IncrementalBody(tissue(), increments=n).load(block, UP).points for n in (4, 8, 16)]
    first, second = (np.abs(ends[i + 1] - ends[i]).max() for i in range(2))
    assert 0 < second < 0.65 * first


def test_under_the_gravity_that_it_is_taken_to_be_free_under_nothing_moves(block):
    body = IncrementalBody(tissue(), free_under=UP)
    assert body.load(block, UP).points == pytest.approx(block.points, abs=1e-9)
    turned = body.load(block, DOWN).points
    twice = IncrementalBody({Label.ADIPOSE: Tissue(1.0, 0.45, 2.0)}).load(block, DOWN).points
    assert turned == pytest.approx(twice, abs=1e-6)


def test_no_increment_is_rejected():
    with pytest.raises(MechanicsError, match="increments = 0 must be 1 or more"):
        IncrementalBody(tissue(), increments=0)


@pytest.fixture(scope="module")
def bar():
    """A cylinder of an irregular mesh; x, y free."""
    return cylinder(15.0, 60.0, 8.0)


def test_in_uniform_strain_a_network_stores_the_energy_of_its_modulus_and_a_quarter(bar):
    """W = E/5 ((tr e)^2 + 2 e : e), as far as the edges run equally in all directions."""
    E, e = 3.0, 1e-4 * np.array([[1.0, 0.4, 0.0], [0.4, -0.5, 0.3], [0.0, 0.3, 0.8]])
    network = SpringNetwork.of(bar, tissue(E, 0.45))
    V = bar_volume(bar)
    for turn in (np.eye(3), rotation(np.array([40.0, 10.0, -70.0]))):
        strain = turn @ e @ turn.T
        W = E / 5 * (np.trace(strain) ** 2 + 2 * np.sum(strain**2))
        assert network.energy(bar.points @ (np.eye(3) + strain)) / V == pytest.approx(W, rel=0.06)


def bar_volume(mesh):
    a = mesh.points[mesh.cells[:, SUBTETRAHEDRA].reshape(-1, 4)]
    return np.abs(np.linalg.det(a[:, 1:] - a[:, :1])).sum() / 6


def test_a_stretched_bar_of_springs_is_softer_than_its_modulus_by_up_to_a_quarter(bar):
    """No exact simulation (Van Gelder): nodes that move freely store less than uniform strain, never more."""
    E, stretch = 3.0, 1e-3
    network = SpringNetwork.of(bar, tissue(E, 0.45))
    ends = [np.flatnonzero(np.abs(bar.points[:, 2] - z) < 1e-6) for z in (0.0, 60.0)]
    held = np.zeros(bar.points.shape, bool)
    for nodes in ends:
        held[nodes, 2] = True
    held[nearest(bar, [0.0, 0.0, 0.0])] = True
    held[nearest(bar, [15.0, 0.0, 0.0]), 1] = True
    uniform = bar.points + stretch * bar.points * [-0.25, -0.25, 1.0]
    x = equilibrium(bar, (network,), start=uniform, held=held).points
    assert network.energy(x) < network.energy(uniform)
    modulus = gradient(network, x)[ends[1], 2].sum() / (np.pi * 15.0**2 * stretch)
    middle = np.abs(bar.points[:, 2] - 30.0) < 15.0
    across = np.linalg.lstsq(bar.points[middle, :1], (x - bar.points)[middle, 0], rcond=None)[0][0]
    assert 0.75 * E < modulus < 1.05 * E
    assert -across / stretch == pytest.approx(0.25, abs=0.06)


def test_a_network_weighs_and_hangs_as_the_solid_of_its_modulus_does_roughly():
    """A half ball that hangs: Poisson's ratio and the mesh leave a quarter."""
    mesh = sphere_part(60.0, 14.0)
    solid = Body(tissue(2.0, 0.25))
    apex = nearest(mesh, [0.0, 0.0, 60.0])
    moved = [b.load(mesh, UP).points[apex, 2] - mesh.points[apex, 2] for b in (solid, as_network(solid))]
    assert moved[1] == pytest.approx(moved[0], rel=0.25)


def ring(columns, off_mm=0.0):
    """A quarter ring of 12 mm on a cylinder about z with semi-axes 140 and 100, turned by a few degrees.

    columns: of cells along the ring; off_mm: (columns + 1,) of its inner side from the cylinder. And how many
    faces lie on its inner side.
    """
    mesh = box((columns, 2, 5), (1.0, 1.0, 1.0), posterior_axis=1)
    s, t, z = mesh.points.T
    angle = np.radians(-135 + 90 * s)
    t = 12 * t + (1 - t) * np.interp(s * columns, np.arange(columns + 1), off_mm + np.zeros(columns + 1))
    points = np.stack([(140 + t) * np.cos(angle), (100 + t) * np.sin(angle), 100 * z - 50], axis=1)
    turn = rotation(np.array([2.0, -1.5, 2.5]))
    faces = mesh.boundaries
    rim = np.array([f for f in faces["skin"] if np.ptp(mesh.points[f, 2]) == 0])
    skin = np.array([f for f in faces["skin"] if np.ptp(mesh.points[f, 2]) > 0])
    # box has its axes in another handedness once bent: orient by volume.
    cells = mesh.cells
    bent = TetMesh(points @ turn.T, cells, mesh.tissue, {})
    a = bent.points[cells[:, :4]]
    flipped = np.linalg.det(a[:, 1:] - a[:, :1]) < 0
    assert flipped.all() or not flipped.any()
    if flipped.all():
        cells = cells[:, [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
        rim, skin, ribs = (f[:, [0, 2, 1, 5, 4, 3]] for f in (rim, skin, faces["posterior"]))
    else:
        ribs = faces["posterior"]
    return TetMesh(bent.points, cells, mesh.tissue, {"skin": skin, "posterior": np.vstack([ribs, rim])}), len(
        ribs
    )


@pytest.fixture(scope="module")
def on_ribs():
    return ring(14)


def test_what_stands_off_the_ribs_or_is_steep_is_not_on_them():
    """Columns of 3.7 mm: a shelf of 4 mm behind slopes of 28 degrees, steps of 47, a shelf of 8 mm."""
    off = np.zeros(57)
    off[6:13] = [2, 4, 4, 4, 4, 4, 2]
    off[25:27] = 4
    off[40:49] = [2, 4, 6, 8, 8, 8, 6, 4, 2]
    mesh, _ = ring(56, off)
    column = np.searchsorted(np.linspace(0, 1, 57), along_the_ring(mesh, ribs_of(mesh).faces)) - 1
    found = set(column)
    assert {*range(5, 13)} <= found, "slopes and shelf of 4 mm"
    assert not {24, 26} & found, "steps"
    assert {25} <= found, "between the steps"
    assert not {43, 44} & found, "shelf of 8 mm"
    assert {0, 20, 30, 55} <= found


def along_the_ring(mesh, faces):
    """From 0 to 1, of the middles of faces."""
    turn = rotation(np.array([2.0, -1.5, 2.5]))
    x, y, _ = (mesh.points[faces[:, :3]].mean(axis=1) @ turn).T
    return (np.degrees(np.arctan2(y / 100, x / 140)) + 135) / 90


def test_the_ribs_are_found_behind_a_body_and_the_cuts_are_none(on_ribs):
    mesh, count = on_ribs
    found = ribs_of(mesh)
    assert len(found.faces) == count
    assert found.residual_mm < 1.0
    assert np.abs(found.wall.distance(mesh.points[np.unique(found.faces)])).max() < 2.0


def test_a_body_without_round_ribs_is_rejected(block):
    with pytest.raises(MechanicsError, match="leave sliding and chest_wall out"):
        ribs_of(block)


def test_what_slides_is_free_and_the_rim_is_held(on_ribs):
    mesh, _ = on_ribs
    ribs = ribs_of(mesh)
    body = Body(tissue(5.0), (Slides(ribs.faces, ribs.wall, 30.0, 0.0), ChestWall(ribs.wall, 30.0)))
    held = body.held(mesh).all(axis=1)
    posterior = mesh.boundary_nodes("posterior")
    assert 0 < held.sum() < len(posterior)
    assert set(np.flatnonzero(held)) <= set(posterior)
    still = Body(body.tissues).load(mesh, DOWN).points - mesh.points
    slid = body.load(mesh, DOWN).points - mesh.points
    free = np.setdiff1d(posterior, np.flatnonzero(held))
    assert not still[free].any()
    assert np.linalg.norm(slid[free], axis=1).max() > 0.05
    apart = ribs.wall.distance(mesh.points[free] + slid[free]) - ribs.wall.distance(mesh.points[free])
    assert np.abs(apart).max() < 0.1 * np.linalg.norm(slid[free], axis=1).max()


def test_all_stiffnesses_scale_with_the_moduli(on_ribs):
    ribs = ribs_of(on_ribs[0])
    body = Body(tissue(), (Slides(ribs.faces, ribs.wall, 30.0, 0.1), ChestWall(ribs.wall, 20.0))).stiffened(
        2.0
    )
    slides, wall = body.parts
    assert (slides.normal_kpa_per_mm, slides.tangential_kpa_per_mm, wall.penalty_kpa_per_mm) == (
        60.0,
        0.2,
        40.0,
    )
    assert type(as_network(body).stiffened(2.0)) is type(as_network(body))
    assert isinstance(ribs.wall, EllipticCylinder)
