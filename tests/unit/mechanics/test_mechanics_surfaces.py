"""A face drawn in an STL file is that face; a file that cannot be meant is rejected by name, in seconds."""

import time
from dataclasses import replace

import meshio
import numpy as np
import pytest

from mammosim.core.errors import MammosimError, MechanicsError
from mammosim.io.surfaces import digest_of, read_closed_surface
from mammosim.mechanics.described import Described, Size
from mammosim.mechanics.paddles import Plates
from mammosim.mechanics.plate_shapes import Curved, Surface

DEPTH, WIDTH, HEIGHT = 60.0, 80.0, 12.0
BOX = Plates(np.array([3.0, 2.0, 1.0]), np.eye(3), np.array([DEPTH, WIDTH, HEIGHT]) / 2, 6.0)


def block(rise=lambda u, v: 0.0 * u, n=(31, 41)):
    """Points and triangles of a block over a grid, its underside at z = rise, its upper side 12 mm higher."""
    u, v = np.meshgrid(np.linspace(0, DEPTH, n[0]), np.linspace(0, WIDTH, n[1]), indexing="ij")
    low = np.stack([u, v, rise(u - DEPTH / 2, v - WIDTH / 2)], axis=-1).reshape(-1, 3)
    number = np.arange(n[0] * n[1]).reshape(n)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    up = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    after, top = np.roll(rim, -1), number.size
    sides = np.concatenate(
        [np.stack(t, axis=1) for t in ((rim, after, after + top), (rim, after + top, rim + top))]
    )
    points = np.concatenate([low, low + [0.0, 0.0, HEIGHT]])
    return points, np.concatenate([up[:, ::-1], up + top, sides])


def stl(path, points, triangles, **options):
    meshio.stl.write(path, meshio.Mesh(points, [("triangle", triangles)]), **options)
    return str(path)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "paddle.stl"


def shaped(file, **parts):
    return replace(BOX, paddle=Described(shapes=(Surface(file),), **parts))


@pytest.mark.parametrize("binary", [True, False])
def test_a_block_in_a_file_is_the_flat_plate(file, binary):
    plates = shaped(stl(file, *block(n=(3, 4)), binary=binary))
    x = np.random.default_rng(0).uniform(-30.0, 60.0, (500, 3))
    one, other = plates.at(20.0)[0], BOX.at(20.0)[0]
    np.testing.assert_array_equal(one.distance(x), other.distance(x))
    np.testing.assert_array_equal(one.normal(x), other.normal(x))
    plates.require_possible(20.0)


def test_a_surface_is_the_shape_that_was_drawn(file):
    """Facets 2 mm wide leave the arc by 2^2 / 8 r at most, 0.006 mm."""
    arc = Curved(across_radius_mm=90.0)
    points, triangles = block(
        lambda u, v: arc.at(np.stack([u.ravel(), v.ravel()], axis=-1))[0].reshape(u.shape)
    )
    plates = shaped(stl(file, points + [100.0, -7.0, 55.0], triangles[:, ::-1]))
    drawn = replace(BOX, paddle=Described(shapes=(arc,)))
    inside = np.random.default_rng(0).uniform(-22.0, 22.0, (300, 3)) + BOX.centre
    found, exact = (each.gap(inside, 20.0, np.zeros(0)) for each in (plates, drawn))
    assert found == pytest.approx(exact, abs=0.01)
    y = np.random.default_rng(1).uniform(-22.0, 22.0, (300, 2))
    _, slope, _ = plates.at(20.0)[0].deflection.at(y)
    assert slope == pytest.approx(arc.at(y)[1], abs=0.02)


def test_a_smaller_plate_is_the_part_at_the_chest_edge(file):
    name = stl(file, *block(lambda u, v: 0.05 * (u + DEPTH / 2)))
    part = shaped(name, size=Size(width_mm=40.0, depth_mm=30.0, edge_radius_mm=3.0))
    y = np.random.default_rng(1).uniform([-10.0, -15.0], [10.0, 15.0], (100, 2))
    w, slope, _ = part.at(20.0)[0].deflection.at(y)
    # Corners are kept to 1e-3 mm, and are 2 mm apart.
    assert slope == pytest.approx(np.tile([0.05, 0.0], (100, 1)), abs=1e-4)
    assert w == pytest.approx(0.05 * (y[:, 0] + 15.0), abs=1e-3)


def with_a_hole(points, triangles):
    return points, triangles[1:]


def in_metres(points, triangles):
    return points / 1e3, triangles


def in_micrometres(points, triangles):
    return points * 1e3, triangles


def with_one_triangle_turned(points, triangles):
    return points, np.concatenate([triangles[:1, ::-1], triangles[1:]])


def folded(points, triangles):
    """The upper side dips through the underside."""
    bent = points.copy()
    middle = np.hypot(bent[:, 0] - 30, bent[:, 1] - 40) < 12
    bent[(points[:, 2] == HEIGHT) & middle, 2] = -5.0
    return bent, triangles


def overhanging(points, triangles):
    """A part of the underside is pushed beneath another."""
    bent = points.copy()
    lip = (points[:, 2] == 0) & (np.abs(points[:, 0] - 30) < 5) & (np.abs(points[:, 1] - 40) < 20)
    bent[lip] += [14.0, 0.0, -6.0]
    return bent, triangles


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (with_a_hole, r"is open: 3 edges are not between two triangles, as at \(.*\) mm; close its holes"),
        (with_one_triangle_turned, "is open: [0-9]+ edges are not between two triangles"),
        (in_metres, r"is 0\.08 mm wide, outside 30 to 600 mm; in metres\? Write it in mm"),
        (in_micrometres, r"is 8e\+04 mm wide.* in micrometres\?"),
        (folded, "overhangs or meets itself at x"),
        (overhanging, "overhangs or meets itself at x"),
    ],
)
def test_a_file_that_cannot_be_meant_is_rejected_by_name_within_five_seconds(file, made, words):
    name = stl(file, *made(*block(n=(141, 181))), binary=True)  # 100,000 triangles
    began = time.perf_counter()
    with pytest.raises(MammosimError, match=rf"paddle\.stl.*{words}"):
        Surface(name)
    assert time.perf_counter() - began < 5.0


def test_what_is_no_stl_or_not_there_is_rejected(file):
    with pytest.raises(MammosimError, match=r"no surface .*paddle\.stl"):
        Surface(str(file))
    file.write_text("not a surface\n" * 20)
    with pytest.raises(MammosimError, match=r"paddle\.stl (is no STL file|has 0 triangles)"):
        read_closed_surface(file)
    file.write_bytes(b"solid x\nendsolid x\n")
    with pytest.raises(MammosimError, match=r"paddle\.stl"):
        read_closed_surface(file)


def test_a_surface_too_small_for_its_plate_or_with_steps_is_rejected(file):
    name = stl(file, *block())
    wide = replace(BOX, half_sizes=np.array([50.0, 60.0, 6.0]), paddle=Described(shapes=(Surface(name),)))
    with pytest.raises(
        MechanicsError, match=r"covers 60 x 80 mm, the plate has 100 x 120 mm: reduce its size"
    ):
        wide.require_possible()
    rough = stl(file.with_name("rough.stl"), *block(lambda u, v: np.where(u > 0, 4.0, 0.0)))
    with pytest.raises(MechanicsError, match=r"rough\.stl has steps or edges on its face"):
        shaped(rough).require_possible()


def test_a_file_that_changed_since_is_rejected(file):
    name = stl(file, *block())
    known = digest_of(name)
    Surface(name, known)
    stl(file, *block(lambda u, v: 0.01 * u))
    with pytest.raises(MechanicsError, match="has changed since"):
        Surface(name, known)
