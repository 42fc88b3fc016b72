"""The same labels and surfaces give the same mesh on every machine."""

import json
import os
import platform
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from instruction_sets import INSTRUCTION_SETS
from meshing_bodies import (
    CROP,
    SIZE,
    breasts_on_a_slab,
    digests,
    last_bits,
    meshed,
    perturbed,
    perturbed_grid,
)

from mammosim.core.mesh import EDGES, TetMesh
from mammosim.core.volume import Grid, LabelMap, grid_around
from mammosim.meshing.body import ElementSize, crop_body, mesh_body
from mammosim.meshing.distance import NearestOnTriangles
from mammosim.meshing.lattice import LIMIT, POINT_MM, on_lattice
from mammosim.meshing.quality import require_sound
from mammosim.meshing.surface import Surface, surface_of_field
from mammosim.meshing.tetrahedra import mesh_surface

# Another machine is at most this far away: 1e6 times the last bit of a number in double precision.
RELATIVE = 1e-9


@pytest.fixture(scope="module")
def labels() -> LabelMap:
    return breasts_on_a_slab()


@pytest.fixture(scope="module")
def mesh(labels: LabelMap) -> TetMesh:
    return meshed(labels)


def _require_same(mesh: TetMesh, other: TetMesh) -> None:
    """Same cells, tissue and boundaries; points to 1e-6 mm."""
    np.testing.assert_array_equal(mesh.cells, other.cells)
    np.testing.assert_array_equal(mesh.tissue, other.tissue)
    assert mesh.boundaries.keys() == other.boundaries.keys()
    for name, faces in mesh.boundaries.items():
        np.testing.assert_array_equal(faces, other.boundaries[name])
    np.testing.assert_allclose(mesh.points, other.points, rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_the_same_mesh_comes_of_inputs_that_differ_in_their_last_digits(
    labels: LabelMap, mesh: TetMesh, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    shaken = LabelMap(perturbed_grid(labels.grid, RELATIVE, rng), labels.values)
    limits = perturbed([CROP["posterior_limit_mm"], *CROP["height_limits_mm"]], RELATIVE, rng)
    size = ElementSize(*perturbed(list(vars(SIZE).values()), RELATIVE, rng))
    cropped = crop_body(shaken, posterior_limit_mm=limits[0], height_limits_mm=tuple(limits[1:]))
    _require_same(mesh_body(cropped, size=size), mesh)


def test_the_mesh_moves_with_the_grid(labels: LabelMap) -> None:
    grid = labels.grid
    upright = Grid(grid.shape, grid.spacing, np.zeros(3))
    at_home, moved = (mesh_body(LabelMap(g, labels.values), size=SIZE) for g in (upright, grid))
    placed = at_home.moved_to(grid.points(upright.indices(at_home.points)))
    _require_same(placed, moved)
    middles = moved.points[moved.cells[:, np.array(EDGES)]].mean(axis=2)
    np.testing.assert_allclose(moved.points[moved.cells[:, 4:]], middles, rtol=0, atol=1e-12)


def test_a_left_handed_grid_has_a_sound_mesh_too(labels: LabelMap) -> None:
    mirrored = replace(labels.grid, direction=labels.grid.direction * [1, 1, -1])
    require_sound(mesh_body(LabelMap(mirrored, labels.values), size=SIZE))


@pytest.mark.parametrize("seed", range(3))
def test_voxels_on_a_limit_are_kept_whatever_the_last_digits(labels: LabelMap, seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = Grid(labels.grid.shape, np.array([0.7, 0.9, 1.1]), np.array([-20.3, 7.7, 100.1]))
    limits = {
        "posterior_limit_mm": 7.7 + 18 * 0.9,
        "height_limits_mm": (100.1 + 5 * 1.1, 100.1 + 30 * 1.1),
    }
    wanted = crop_body(LabelMap(grid, labels.values), **limits).values
    assert (wanted[5:31, :19] == labels.values[5:31, :19]).all()
    shaken = LabelMap(perturbed_grid(grid, RELATIVE, rng), labels.values)
    np.testing.assert_array_equal(crop_body(shaken, **limits).values, wanted)


@pytest.fixture(scope="module")
def ellipsoid() -> tuple[np.ndarray, Grid]:
    """A field with zeros at voxel centres, in a box whose sides are planes of them."""
    semi_axes = np.array([40.0, 30.0, 25.0])
    grid = grid_around(-semi_axes - 6.25, semi_axes + 6.25, 2.5)
    field = (np.linalg.norm(grid.centres() / semi_axes, axis=1) - 1) * semi_axes.min()
    return np.maximum(field, grid.centres()[:, 1] - 20.0).reshape(grid.shape), grid


@pytest.mark.parametrize("seed", range(3))
def test_the_same_mesh_comes_of_fields_and_surfaces_that_differ_in_their_last_digits(
    ellipsoid: tuple[np.ndarray, Grid], seed: int
) -> None:
    field, grid = ellipsoid
    surface = surface_of_field(field, grid)
    wanted = mesh_surface(surface, size=12.0)
    rng = np.random.default_rng(seed)
    noise = rng.uniform(-1e-12, 1e-12, field.shape)
    _require_same(mesh_surface(surface_of_field(field + noise, grid), size=12.0), wanted)
    moved = Surface(surface.points + rng.uniform(-1e-9, 1e-9, surface.points.shape), surface.triangles)
    _require_same(mesh_surface(moved, size=lambda points: np.full(len(points), 12 * (1 + 1e-9))), wanted)


def test_means_of_lattice_values_are_rounded_alike_whatever_their_last_bits() -> None:
    values = POINT_MM * np.arange(-50, 50)
    for parts in (2, 3, 4, 8):
        means = (values[:, None] + POINT_MM * np.arange(parts) / parts).ravel()
        rounded = on_lattice(means, POINT_MM)
        np.testing.assert_array_equal(on_lattice(means + 1e-9, POINT_MM), rounded)
        np.testing.assert_array_equal(on_lattice(means - 1e-9, POINT_MM), rounded)
        assert np.abs(rounded - means).max() < (1 - LIMIT) * POINT_MM


def test_of_two_triangles_equally_far_the_first_is_the_nearest() -> None:
    triangle = np.array([[0.0, 0, 3], [10, 0, 3], [0, 10, 3]])
    below = triangle * [1, 1, -1]
    for shift in (-1e-15, 0.0, 1e-15):
        _, which = NearestOnTriangles(np.stack([triangle, below + [0, 0, shift]]))(np.array([[2.0, 2, 0]]))
        assert which == [0]


def test_the_same_bytes_come_of_other_vector_instructions(mesh: TetMesh) -> None:
    """Those of the oldest processor; the whole chain is run with the others, too, before a release."""
    script = Path(__file__).with_name("meshing_bodies.py")
    environment = os.environ | INSTRUCTION_SETS["plain"]
    child = subprocess.run(
        [sys.executable, script], env=environment, capture_output=True, text=True, timeout=300, check=True
    )
    there = json.loads(child.stdout)
    if platform.machine() in ("x86_64", "AMD64"):
        # Otherwise the child computed alike, and this test would say nothing.
        assert there["last_bits"] != last_bits()
    assert there["mesh"] == digests(mesh)
