"""The same scene seen otherwise: turned, scaled, renumbered, loaded in steps, reached another way.

A scene and its twin have the same answer; `Twin.back` carries the twin's shape to the scene's.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.study.hard_cases.scenes import Scene, Wall


@dataclass(frozen=True)
class Twin:
    """The same scene seen otherwise; back: its shape (n_node, 3) as that of the scene."""

    scene: Scene
    back: Callable[[np.ndarray], np.ndarray]
    by_way_of: tuple[np.ndarray, ...] = ()


def turned(scene: Scene, *, degrees: list[float]) -> Twin:
    """Everything turned about x, then y, then z."""
    R = Rotation.from_euler("xyz", degrees, degrees=True).as_matrix()
    wall = (
        None
        if scene.wall is None
        else replace(scene.wall, centre=R @ scene.wall.centre, axes=R @ scene.wall.axes)
    )
    gravity = None if scene.gravity is None else R @ scene.gravity
    mesh = scene.mesh.moved_to(scene.mesh.points @ R.T)
    press = scene.press and scene.press.turned(R)
    return Twin(replace(scene, mesh=mesh, gravity=gravity, wall=wall, press=press), lambda x: x @ R)


def shifted(scene: Scene, *, mm: list[float]) -> Twin:
    """Everything elsewhere."""
    wall = None if scene.wall is None else replace(scene.wall, centre=scene.wall.centre + mm)
    there = replace(scene, mesh=scene.mesh.moved_to(scene.mesh.points + mm), wall=wall)
    return Twin(there, lambda x: x - mm)


def scaled(scene: Scene, *, length: float, stiffness: float) -> Twin:
    """Lengths times s, stresses times c, so densities times c / s: displacements become s times as large."""
    s, c = length, stiffness
    tissues = {
        label: Tissue(c * t.youngs_modulus_kpa, t.poisson_ratio, c / s * t.density_g_cm3)
        for label, t in scene.tissues.items()
    }
    skin = scene.skin and replace(
        scene.skin,
        youngs_modulus_kpa=c * scene.skin.youngs_modulus_kpa,
        thickness_mm=s * scene.skin.thickness_mm,
    )
    there = replace(
        scene,
        mesh=scene.mesh.moved_to(s * scene.mesh.points),
        tissues=tissues,
        skin=skin,
        wall=scene.wall and _scaled_wall(scene.wall, s),
        contact=scene.contact and c / s * scene.contact,
        sliding=scene.sliding and (c / s * scene.sliding[0], c / s * scene.sliding[1]),
    )
    return Twin(there, lambda x: x / s)


def _scaled_wall(wall: Wall, s: float) -> Wall:
    lengths = {f.name: s * getattr(wall, f.name) for f in fields(wall) if f.name != "axes"}
    return replace(wall, **lengths)


def renumbered(scene: Scene, *, seed: int) -> Twin:
    """Nodes and elements in another order."""
    mesh, rng = scene.mesh, generator("renumbered", str(seed))
    order, cells = rng.permutation(len(mesh.points)), rng.permutation(len(mesh.cells))
    new = np.argsort(order)
    other = TetMesh(
        mesh.points[order],
        new[mesh.cells[cells]],
        mesh.tissue[cells],
        {name: new[faces] for name, faces in mesh.boundaries.items()},
    )
    held = None if scene.held is None else scene.held[order]
    return Twin(replace(scene, mesh=other, held=held), lambda x: x[new])


def stepwise(scene: Scene, *, load_steps: int) -> Twin:
    """The load in equal steps, where the scene has it suddenly."""
    return Twin(replace(scene, load_steps=load_steps), lambda x: x)


def by_way_of(scene: Scene, *, gravity: list[list[float]]) -> Twin:
    """The scene's equilibrium reached from those under other directions of gravity, one after the other."""
    return Twin(scene, lambda x: x, tuple(np.array(g, dtype=float) for g in gravity))


TWINS: Mapping[str, Callable[..., Twin]] = {
    "turned": turned,
    "shifted": shifted,
    "scaled": scaled,
    "renumbered": renumbered,
    "stepwise": stepwise,
    "by_way_of": by_way_of,
}


def twin(scene: Scene, change: Mapping[str, Mapping[str, Any]]) -> Twin:
    """The scene changed as {name of TWINS: values}, one change after the other."""
    found = Twin(scene, lambda x: x)
    for name, values in change.items():
        next_one = TWINS[name](found.scene, **values)
        found = Twin(next_one.scene, partial(_back, found.back, next_one.back), next_one.by_way_of)
    return found


def _back(first: Callable, second: Callable, x: np.ndarray) -> np.ndarray:
    return first(second(x))


def shape_of(twin: Twin) -> np.ndarray:
    """The twin's equilibrium (n_node, 3) as a shape of the scene. Raises as Scene.equilibrium does."""
    start = None
    for gravity in twin.by_way_of:
        start = replace(twin.scene, gravity=gravity).equilibrium(start=start).points
    return twin.back(twin.scene.equilibrium(start=start).points)
