"""What is held in a hard case: which degrees of freedom stay, and where."""

from collections.abc import Callable, Mapping
from typing import Literal

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.equilibrium import held_nodes

# (n_node, 3) bool, None where nothing says so; and a start (n_node, 3) mm where held nodes stay elsewhere.
Held = tuple[np.ndarray | None, np.ndarray | None]


def _posterior(mesh: TetMesh, stretch: float) -> Held:
    return (held_nodes(mesh) if "posterior" in mesh.boundaries else None), None


def _at(mesh: TetMesh, axis: int, place: float) -> np.ndarray:
    return np.isclose(mesh.points[:, axis], place)


def _rollers(mesh: TetMesh, stretch: float) -> Held:
    """No lateral displacement anywhere; the face z = 0 is held."""
    held = np.ones(mesh.points.shape, dtype=bool)
    held[:, 2] = _at(mesh, 2, 0.0)
    return held, None


def _plane_strain(mesh: TetMesh, stretch: float) -> Held:
    """Stretched along x, nothing moves along y, the face z = 0 stays in its plane."""
    ends = _at(mesh, 0, 0.0) | _at(mesh, 0, mesh.points[:, 0].max())
    held = np.stack([ends, np.ones(len(ends), dtype=bool), _at(mesh, 2, 0.0)], axis=1)
    return held, mesh.points * [stretch, 1.0, 1.0]


def _symmetry(mesh: TetMesh, stretch: float) -> Held:
    """The face y = 0 stays in its plane; nothing else is held."""
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[:, 1] = _at(mesh, 1, 0.0)
    return held, None


def _planes(**places: float) -> Callable[[TetMesh, float], Held]:
    """Each plane x, y or z = part of the body's extent stays in its plane; nothing else is held."""

    def held_by(mesh: TetMesh, stretch: float) -> Held:
        held = np.zeros(mesh.points.shape, dtype=bool)
        for name, part in places.items():
            axis = "xyz".index(name)
            low, high = mesh.points[:, axis].min(), mesh.points[:, axis].max()
            held[:, axis] = _at(mesh, axis, low + part * (high - low))
        return held, None

    return held_by


def _confined(mesh: TetMesh, stretch: float) -> Held:
    """Nothing moves along x or z; the plane half way along y stays in its plane."""
    held, _ = _planes(y=0.5)(mesh, stretch)
    return (None if held is None else held | [True, False, True]), None


def _posterior_along(axis: int) -> Callable[[TetMesh, float], Held]:
    """The nodes of `posterior`, in one direction only."""

    def held_by(mesh: TetMesh, stretch: float) -> Held:
        return held_nodes(mesh) & (np.arange(3) == axis), None

    return held_by


HeldNames = Literal[
    "posterior",
    "rollers",
    "plane_strain",
    "symmetry",
    "octant",
    "free_sides",
    "confined",
    "posterior_along_x",
    "posterior_along_y",
    "posterior_along_z",
]
HELD: Mapping[HeldNames, Callable[[TetMesh, float], Held]] = {
    "posterior": _posterior,
    "rollers": _rollers,
    "plane_strain": _plane_strain,
    "symmetry": _symmetry,
    "octant": _planes(x=0.0, y=0.0, z=0.0),
    "free_sides": _planes(x=0.0, y=0.5, z=0.0),
    "confined": _confined,
    "posterior_along_x": _posterior_along(0),
    "posterior_along_y": _posterior_along(1),
    "posterior_along_z": _posterior_along(2),
}
