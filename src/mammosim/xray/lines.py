"""Where the material changes along the lines of voxels of a phantom."""

from typing import NamedTuple

import numpy as np

from mammosim.io.compiled import njit
from mammosim.xray.phantom import Phantom


class Lines(NamedTuple):
    """Where the material changes along each line of voxels, and the grid of the lines.

    first: (n_line + 1,) the changes of line j + k ny are first[line] to first[line + 1].
    face: (n_change,) X in mm; after: (n_change,) uint8 material beyond it.
    low, spacing: (3,) mm of the grid in (x, y, z); ny, nz: lines along y and z.
    """

    first: np.ndarray
    face: np.ndarray
    after: np.ndarray
    low: np.ndarray
    spacing: np.ndarray
    ny: int
    nz: int


def lines_along(phantom: Phantom, axis: int) -> Lines:
    """The lines of a phantom along one axis (0, 1, 2), which is called x here; y, z are the others."""
    others = [a for a in range(3) if a != axis]
    order = (axis, *others)
    index = np.ascontiguousarray(phantom.index.transpose([2 - a for a in order[::-1]]))
    low, spacing = phantom.low[list(order)], phantom.grid.spacing[list(order)]
    lines = index.reshape(-1, index.shape[2])
    first = np.concatenate([[0], np.cumsum(_changes(lines))])
    place, after = _filled(lines, first)
    return Lines(first, low[0] + spacing[0] * place, after, low, spacing, index.shape[1], index.shape[0])


def no_lines() -> Lines:
    """A grid of air only."""
    return Lines(np.zeros(2, np.int64), np.zeros(0), np.zeros(0, np.uint8), -np.ones(3), np.ones(3), 1, 1)


@njit(cache=True)
def _changes(lines: np.ndarray) -> np.ndarray:
    """Changes of material (n_line,) along lines (n_line, nx), from air and to air at the ends."""
    n_line, nx = lines.shape
    changes = np.zeros(n_line, np.int64)
    for line in range(n_line):
        found = 0
        for i in range(1, nx):
            found += lines[line, i] != lines[line, i - 1]
        changes[line] = found + (lines[line, 0] != 0) + (lines[line, nx - 1] != 0)
    return changes


@njit(cache=True)
def _filled(lines: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (n_change,), counted from the lower end of the line, and the material (n_change,) beyond each."""
    n_line, nx = lines.shape
    place, after = np.empty(first[-1], np.int64), np.empty(first[-1], np.uint8)
    for line in range(n_line):
        at = first[line]
        if at == first[line + 1]:
            continue
        before = 0
        for i in range(nx):
            if lines[line, i] != before:
                before = lines[line, i]
                place[at], after[at] = i, before
                at += 1
        if before != 0:
            place[at], after[at] = nx, 0
    return place, after
