"""A body to mesh on several machines, and as a script: what its mesh is on this one."""

import hashlib
import json
from dataclasses import replace

import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.volume import Grid, LabelMap
from mammosim.meshing.body import ElementSize, crop_body, mesh_body

SIZE = ElementSize(breast_mm=12.0, chest_mm=16.0)
CROP = {"posterior_limit_mm": 65.0, "height_limits_mm": (20.0, 112.0)}
# By 16.26 degrees about z, then by 36.87 about the new x, in decimals, which need no sine.
TURNED = np.array([[0.96, -0.224, 0.168], [0.28, 0.768, -0.576], [0.0, 0.6, 0.8]])


def breasts_on_a_slab(centres_mm: tuple[float, ...] = (38.0, 118.0)) -> LabelMap:
    """Half ellipsoids with glands on fat, muscle and thorax, in a turned grid of unequal steps.

    centres_mm: x of each breast. The borders are half integers of a voxel, where distances have ties.
    """
    spacing = np.array([2.9, 3.125, 2.7])
    grid = Grid((34, 24, 54), spacing, np.array([-101.3, -77.7, 33.1]), TURNED)
    k, j, i = np.ogrid[tuple(slice(n) for n in grid.shape)]
    x, y, z = i * spacing[0], j * spacing[1], k * spacing[2]
    r = [((x - x0) / 34) ** 2 + ((y - 50) / 36) ** 2 + ((z - 46) / 32) ** 2 for x0 in centres_mm]
    nearest = np.min(r, axis=0)
    values = np.where((nearest < 1) | (j > 15), Label.ADIPOSE, Label.AIR)
    values[(nearest < 0.4) & (j < 16)] = Label.GLANDULAR
    values[:, 17:] = Label.MUSCLE
    values[:, 20:] = Label.THORAX
    return LabelMap(grid, values.astype(np.uint8))


def meshed(labels: LabelMap) -> TetMesh:
    """The cropped body's mesh."""
    return mesh_body(crop_body(labels, **CROP), size=SIZE)


def perturbed(values: np.ndarray | float, relative: float, rng: np.random.Generator) -> np.ndarray:
    """Values of any shape, each changed by at most that part of the largest of them."""
    values = np.asarray(values, dtype=float)
    return values + relative * np.abs(values).max() * rng.uniform(-1, 1, values.shape)


def perturbed_grid(grid: Grid, relative: float, rng: np.random.Generator) -> Grid:
    """The grid with another spacing, origin and direction."""
    names = ("spacing", "origin", "direction")
    return replace(grid, **{name: perturbed(getattr(grid, name), relative, rng) for name in names})


def digests(mesh: TetMesh) -> dict[str, str]:
    """What identifies the bytes of each array of a mesh."""
    arrays = {"points": mesh.points, "cells": mesh.cells, "tissue": mesh.tissue, **mesh.boundaries}
    return {name: hashlib.sha256(np.ascontiguousarray(a).tobytes()).hexdigest() for name, a in arrays.items()}


def last_bits() -> str:
    """Digest of a product of matrices, whose last bits show which kernels this process computes with."""
    A = np.random.default_rng(1).normal(size=(64, 64))
    return hashlib.sha256((A @ A).tobytes()).hexdigest()


if __name__ == "__main__":
    print(json.dumps({"last_bits": last_bits(), "mesh": digests(meshed(breasts_on_a_slab()))}))  # noqa: T201
