"""What a registration without markers is put together of, each piece by itself on a torso of a few voxels."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from mammosim.core.errors import ImageError
from mammosim.core.rigid import IDENTITY, RigidTransform, rotation
from mammosim.core.volume import Grid, Image
from mammosim.imaging import alignment, unmarked
from mammosim.imaging.alignment import Chest, aligned_skins, evened, skin_points, starts
from mammosim.imaging.certainty import PartsOfChest, parts_of_chest
from mammosim.imaging.unmarked import Pair, register_unmarked

OBLIQUE = rotation(np.array([0.0, 0.0, 25.0]))
TURN = rotation(np.array([0.0, 0.0, 6.0]))


def grid_of(shape, spacing, direction=OBLIQUE) -> Grid:
    """A grid about the origin."""
    spacing = np.array(spacing, float)
    return Grid(shape, spacing, -direction @ (spacing * (np.array(shape[::-1]) - 1) / 2), direction)


def texture(points: np.ndarray) -> np.ndarray:
    """Brightness at points (n, 3): waves on a slope, the same whatever the voxels are."""
    x, y, z = points.T
    return 3 * np.sin(x / 13) + 3 * np.cos(y / 11) * np.sin(z / 12) + points @ [0.05, -0.08, 0.04]


def torso(
    grid: Grid, motion: RigidTransform = IDENTITY, *, breast_mm=0.0, ribs_mm=60.0, ahead_mm=0.0
) -> Chest:
    """A cylinder without ends of half axes 120 and 80 mm, moved; its rib cage is around `ahead_mm`."""
    x = motion.inverse()(grid.centres())
    front = 1 + breast_mm / 80 * ((x[:, 1] < 0) & (np.abs(x[:, 0]) < 70))
    body = (x[:, 0] / 120) ** 2 + (x[:, 1] / 80 / front) ** 2 < 1
    ribs = ((x[:, 0] / 100) ** 2 + (x[:, 1] / 65) ** 2 < 1) & (np.abs(x[:, 2] - ahead_mm) <= ribs_mm)
    light = np.where(body, texture(x / 2), 0).astype(np.float32)
    return Chest(Image(grid, light.reshape(grid.shape)), body.reshape(grid.shape), ribs.reshape(grid.shape))


TORSO = grid_of((26, 42, 42), (7.0, 7.0, 9.0))


def test_skins_lie_on_each_other_whatever_hangs_in_front_and_are_not_shifted_along_the_torso():
    """A tilted grid, a turn and a shift across; where the rib cages are says how far along."""
    motion = RigidTransform(TURN, np.array([14.0, -9.0, 0.0]))
    moved = torso(TORSO, motion, breast_mm=25.0, ahead_mm=30.0)
    found = aligned_skins(torso(TORSO), moved).after(motion)
    assert found.angle_deg < 1.0
    assert np.linalg.norm(found(np.zeros((1, 3)))[0, :2]) < 2.0
    assert found.t[2] == pytest.approx(-30.0, abs=5.0)  # a voxel is 9 mm


def test_where_an_image_ends_is_no_skin():
    chest = torso(TORSO)
    at = TORSO.indices(skin_points(chest))
    assert len(at) > 500
    assert at.min() > 1.5
    assert (at.max(axis=0) < np.array(TORSO.shape) - 2.5).all()


def test_what_is_bright_alike_is_even_up_to_the_skin_and_dark_outside():
    chest = torso(TORSO)
    even = evened(Image(TORSO, np.full(TORSO.shape, 700.0, np.float32)), chest.body).values
    np.testing.assert_allclose(even[chest.body], 1.0, atol=0.02)
    assert not even[~chest.body].any()


def test_a_chest_of_which_an_image_shows_a_part_is_found_in_a_whole_one(monkeypatch):
    """Two fifths of the rib cage: the half that both must share is one of the smaller one."""
    for name in ("TURNS_DEG", "NEAR_TURNS_DEG"):
        monkeypatch.setattr(alignment, name, (0.0,))
    monkeypatch.setattr(alignment, "aligned_skins", lambda fixed, moving: IDENTITY)
    motion = RigidTransform(np.eye(3), np.array([24.0, -12.0, 12.0]))
    best = starts(torso(TORSO), torso(TORSO, motion, ribs_mm=24.0))[0]
    np.testing.assert_allclose(best.motion.t, -motion.t, atol=6.0)  # half a voxel of 12 mm
    assert best.correlation > 0.9


def test_parts_step_to_where_a_known_motion_ends_on_a_tilted_grid_under_any_coil():
    """m = 2.5 f(S y) + 7: S is the step, whatever slope the brightness has as a whole."""
    grid = grid_of((24, 30, 40), (3.0, 4.0, 6.0))
    y = grid.centres()
    S = RigidTransform(rotation(np.array([0.3, -0.2, 0.4])), np.array([0.4, -0.3, 0.5]))
    fixed, moved = texture(y), 2.5 * texture(S(y)) + 7
    inside = np.zeros(grid.shape, bool)
    inside[3:-3, 4:-4, 4:-4] = True
    images = [Image(grid, each.reshape(grid.shape).astype(np.float32)) for each in (fixed, moved)]
    parts = parts_of_chest(*images, inside)
    points = grid.points(np.argwhere(inside).astype(float))
    off = np.linalg.norm(parts.step(points) - S(points), axis=1)
    assert off.max() < 0.1 * np.linalg.norm(S(points) - points, axis=1).max()


def test_the_correlation_is_that_of_the_rib_cage_whatever_is_around_it():
    grid = grid_of((20, 20, 20), (4.0, 4.0, 4.0))
    inside = np.zeros(grid.shape, bool)
    inside[5:-5, 5:-5, 5:-5] = True
    f = texture(grid.centres()).reshape(grid.shape)
    m = np.where(inside, 2 * f + 3, 0)
    m[3:-3, 3:-3, 3:-3] = 2 * f[3:-3, 3:-3, 3:-3] + 3
    m[:2] = 500.0
    parts = parts_of_chest(*(Image(grid, each.astype(np.float32)) for each in (f, m)), inside)
    assert parts.correlation > 0.9999


@pytest.mark.parametrize(
    ("shift", "turn", "fixed"), [(1.0, 2e4, True), (1.0, 1.0, False), (1e-1, 1e8, False)]
)
def test_a_turn_counts_as_the_shift_at_a_tenth_of_a_metre(shift, turn, fixed):
    A = np.tile(np.diag([shift] * 3 + [turn] * 3), (8, 1, 1))
    values = (A, np.zeros((8, 6)), np.zeros(3), 1.0)
    if fixed:
        assert PartsOfChest(*values).theta.shape == (6,)
    else:
        with pytest.raises(ImageError, match="too little structure"):
            PartsOfChest(*values)


def test_only_what_is_body_in_both_images_and_rib_cage_is_compared(monkeypatch):
    """The moving body ends in the middle of the fixed one once it is moved by two voxels."""
    grid = Grid((6, 6, 8), np.full(3, 5.0), np.zeros(3))
    whole, half, ribs = np.ones(grid.shape, bool), np.zeros(grid.shape, bool), np.zeros(grid.shape, bool)
    half[:, :, 2:6] = True
    ribs[1:5, 1:5, 1:7] = True
    image = Image(grid, np.ones(grid.shape, np.float32))
    seen = {}
    monkeypatch.setattr(unmarked, "evened", lambda image, body: seen.update(body=body) or image)
    monkeypatch.setattr(unmarked, "parts_of_chest", lambda still, moved, inside: seen.update(inside=inside))
    Pair(image, image, (whole, half), ribs).parts(RigidTransform(np.eye(3), np.array([10.0, 0, 0])))
    both = np.zeros(grid.shape, bool)
    both[:, :, 4:8] = True
    np.testing.assert_array_equal(seen["body"], both)
    np.testing.assert_array_equal(seen["inside"], both & ribs)


def test_the_front_has_the_corners_of_the_rib_cage():
    grid = grid_of((5, 6, 7), (2.0, 3.0, 4.0))
    inside = np.zeros(grid.shape, bool)
    inside[1:4, 2:5, 3:7] = True
    image = Image(grid, np.zeros(grid.shape, np.float32))
    corners = grid.points(np.array([[k, j, i] for k in (1, 3) for j in (2, 4) for i in (3, 6)], float))
    found = Pair(image, image, (inside, inside), inside).front
    assert sorted(map(tuple, found.round(6))) == sorted(map(tuple, corners.round(6)))


@dataclass(frozen=True)
class Pulled:
    """What parts say that pull every motion to an aim, by half of the shift that is left each time."""

    motion: RigidTransform
    aim: RigidTransform
    share: float

    @property
    def step(self) -> RigidTransform:
        left = self.aim.after(self.motion.inverse())
        middle = self.motion(np.zeros((1, 3)))[0]
        aimed = self.aim(np.zeros((1, 3)))[0]
        return RigidTransform(left.R, middle + self.share * (aimed - middle) - left.R @ middle)

    @property
    def theta(self) -> np.ndarray:
        left = self.aim(np.zeros((1, 3)))[0] - self.motion(np.zeros((1, 3)))[0]
        return np.array([*(self.share * left), 0.0, 0.0, 0.0])


@pytest.mark.parametrize(("shift_mm", "steps"), [(0.0, 0), (0.03, 1), (0.5, 5), (1e4, 10)])
def test_the_last_steps_go_on_until_a_hundredth_of_a_millimetre_and_at_most_ten(monkeypatch, shift_mm, steps):
    """Halved each time: of 0.5 mm a step below 0.01 mm is left after five; the turn is made at once."""
    begun = RigidTransform(rotation(np.array([20.0, 0, 0])), np.array([0.0, 40.0, 0]))
    aim = RigidTransform(rotation(np.array([20.0, 0, 50.0])), begun.t + [0, shift_mm, 0])
    monkeypatch.setattr(Pair, "parts", lambda self, motion: Pulled(motion, aim, 0.5))
    motion, parts, taken = Pair(None, None, (None, None), None).last_steps(begun)
    assert taken == steps
    assert parts.motion is motion
    left = np.linalg.norm(motion(np.zeros((1, 3)))[0] - aim(np.zeros((1, 3)))[0])
    assert left == pytest.approx(shift_mm / 2**steps, abs=1e-6)


@pytest.fixture
def tried(monkeypatch):
    """Of starts with these correlations at the end: what the best one is, after how many iterations."""

    def of(*correlations: float):
        at = [RigidTransform(np.eye(3), np.full(3, float(n))) for n in range(len(correlations))]
        monkeypatch.setattr(unmarked, "starts", lambda *_: [SimpleNamespace(motion=motion) for motion in at])
        monkeypatch.setattr(unmarked, "refine", lambda images, inside, motion, _: (motion, 10 + motion.t[0]))
        monkeypatch.setattr(unmarked, "correlation", lambda *given: correlations[int(given[-1].t[0])])
        motion, iterations = unmarked._best_start(torso(TORSO), torso(TORSO))
        return int(motion.t[0]), iterations

    return of


def test_of_the_first_three_starts_the_one_that_ends_best_is_taken(tried):
    assert tried(0.4, 0.9, 0.5, 0.99) == (1, 11)
    assert tried(0.4, 0.3, 0.8) == (2, 12)


def test_chests_that_overlap_nowhere_are_rejected(tried):
    for correlations in ((), (-0.2, -0.5)):
        with pytest.raises(ImageError, match="overlap too little at any shift; check that both"):
            tried(*correlations)


@pytest.fixture
def ended(monkeypatch):
    """Of correlation and limits of the error at corners, before and after the last steps: what is found."""

    def of(before, after):
        start, end = IDENTITY, RigidTransform(TURN, np.ones(3))
        said = [
            SimpleNamespace(
                correlation=r, certainty=SimpleNamespace(at=lambda _, e=e: np.array(e), turn_deg=r)
            )
            for r, e in (before, after)
        ]
        pair = SimpleNamespace(parts=lambda _: said[0], last_steps=lambda _: (end, said[1], 4), front=None)
        monkeypatch.setattr(unmarked, "coarse_chest", lambda image: image)
        monkeypatch.setattr(unmarked, "coarsened", lambda image, voxel_mm: image)
        monkeypatch.setattr(unmarked, "_best_start", lambda *_: (start, 25))
        monkeypatch.setattr(unmarked.Pair, "of", lambda *_: pair)
        return register_unmarked(None, None), start, end

    return of


def test_the_table_has_the_largest_error_at_the_corners_before_and_after(ended):
    found, start, motion = ended((0.3, [40.0, 50.0]), (0.95, [1.0, 9.0]))
    assert (found.landmark, found.refined) == (start, motion)
    rows = found.table.set_index("step")
    assert rows.error_95_mm.tolist() == [50.0, 9.0]
    assert rows.correlation.tolist() == rows.error_95_deg.tolist() == [0.3, 0.95]
    assert rows.iterations.tolist() == [25, 4]


@pytest.mark.parametrize(
    ("r", "error_mm"), [(0.89, 1.0), (0.95, 10.1), (float("nan"), 1.0), (0.95, float("nan"))]
)
def test_what_is_reached_at_the_end_must_be_sure_whatever_it_was_before(ended, r, error_mm):
    ended((0.1, [99.0]), (0.9, [10.0]))
    with pytest.raises(ImageError, match="do not match: at best"):
        ended((0.99, [0.1]), (r, [error_mm]))


def test_a_step_towards_the_skin_goes_along_its_normal_though_the_grid_is_turned():
    """Flat skin at j = 10 of a grid turned by 60 degrees about z; points 3 mm off it come back along j."""
    turned = rotation(np.array([0.0, 0.0, 60.0]))
    grid = Grid((20, 20, 20), np.full(3, 2.0), np.zeros(3), turned)
    distance = np.broadcast_to(2.0 * (np.arange(20.0) - 10)[None, :, None], grid.shape)
    slopes = np.zeros((*grid.shape, 3))
    slopes[..., 1] = 1.0
    k, i = np.meshgrid(np.arange(3.0, 17.0), np.arange(3.0, 17.0))
    x = grid.points(np.stack([k.ravel(), np.full(k.size, 11.5), i.ravel()], axis=1))
    moved = alignment._skin_step(grid, distance, slopes, x)(x)
    np.testing.assert_allclose((moved - x).mean(axis=0), -3.0 * turned[:, 1], atol=0.05)


def test_a_step_turns_points_about_their_own_middle():
    """Flat skin at y = 320 of a grid far from the frame's origin; points tilted by 2 degrees come back."""
    grid = Grid((20, 20, 20), np.full(3, 2.0), np.full(3, 300.0))
    distance = np.broadcast_to(2.0 * (np.arange(20.0) - 10)[None, :, None], grid.shape)
    slopes = np.zeros((*grid.shape, 3))
    slopes[..., 1] = 1.0
    k, i = np.meshgrid(np.arange(3.0, 17.0), np.arange(3.0, 17.0))
    x = grid.points(np.stack([k.ravel(), np.full(k.size, 10.0), i.ravel()], axis=1))
    middle = x.mean(axis=0)
    tilted = middle + (x - middle) @ rotation(np.array([0.0, 0.0, 2.0])).T
    moved = alignment._skin_step(grid, distance, slopes, tilted)(tilted)
    assert np.abs(moved[:, 1] - 320).max() < np.abs(tilted[:, 1] - 320).max() / 4
