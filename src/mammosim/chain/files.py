"""Products of a scene as files: what one job makes and another one goes on with."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.breast import read_breast
from mammosim.chain.graph import Chain
from mammosim.chain.pressed import Pressed
from mammosim.chain.stages import PRODUCTS
from mammosim.chain.xray import Voxels
from mammosim.io.images import read_labels, write_labels
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.xray.dose import GlandularDose

Paths = Sequence[str]


@dataclass(frozen=True)
class Stored:
    """How a product is kept: endings of its files; write(chain, value, paths), read(paths)."""

    endings: tuple[str, ...]
    write: Callable[[Chain, Any, Paths], None]
    read: Callable[[Paths], Any]


def _write_points(chain: Chain, points: np.ndarray, paths: Paths) -> None:
    write_mesh(chain["mesh"].moved_to(points), paths[0])


def _write_pressed(chain: Chain, found: Pressed, paths: Paths) -> None:
    _write_points(chain, found.points, paths)
    # A paddle that hardly touches has no pressed face to measure: JSON has no NaN.
    row = {name: None if value != value else value for name, value in found.row.items()}
    write_json({"row": row, "plates": dict(found.plates)}, paths[1])


def _read_pressed(paths: Paths) -> Pressed:
    """Shape, row and plates; without the tables beside them."""
    facts, nothing = read_json(paths[1]), pd.DataFrame()
    points = read_mesh(paths[0]).points
    row = {name: np.nan if value is None else value for name, value in facts["row"].items()}
    return Pressed(points, nothing, nothing, nothing, nothing, nothing, row, facts["plates"])


def _write_voxels(chain: Chain, voxels: Voxels, paths: Paths) -> None:
    write_labels(voxels.labels, paths[0])
    write_json(dict(voxels.plates), paths[1])


def _plain(values: Any) -> Any:
    return {name: float(value) for name, value in values.items()}


STORED: Mapping[str, Stored] = {
    "mesh": Stored((".vtu",), lambda c, mesh, p: write_mesh(mesh, p[0]), lambda p: read_mesh(p[0])),
    "stress_free": Stored((".vtu",), lambda c, mesh, p: write_mesh(mesh, p[0]), lambda p: read_mesh(p[0])),
    "loaded": Stored((".vtu",), _write_points, lambda p: read_mesh(p[0]).points),
    "pressed": Stored((".vtu", ".json"), _write_pressed, _read_pressed),
    "phantom": Stored(
        (".nii.gz", ".json"), _write_voxels, lambda p: Voxels(read_labels(p[0]), read_json(p[1]))
    ),
    "exposure": Stored(
        (".json",), lambda c, mas, p: write_json({"mas": float(mas)}, p[0]), lambda p: read_json(p[0])["mas"]
    ),
    "dose": Stored(
        (".json",),
        lambda c, dose, p: write_json(asdict(dose), p[0]),
        lambda p: GlandularDose(**read_json(p[0])),
    ),
    "scatter": Stored((".csv",), lambda c, cells, p: write_table(cells, p[0]), lambda p: read_table(p[0])),
    "image": Stored((".json",), lambda c, row, p: write_json(_plain(row), p[0]), lambda p: read_json(p[0])),
    "slices": Stored((".json",), lambda c, row, p: write_json(_plain(row), p[0]), lambda p: read_json(p[0])),
}


def files_of(name: str, paths: Paths) -> list[str]:
    """The files of a product among others, in the order of its endings."""
    return [path for path in paths if Path(path).name.split(".")[0] == name]


def scene_chain(files: Mapping[str, Any], effects: Collection[str], settings: Mapping[str, Any]) -> Chain:
    """The chain of a scene with these effects, and with what was made for it before.

    files: those of chain.breast.read_breast, and `made`, of products; settings: scene (the values of its
    file), settings (of the chain), gravity 'x y z', seed.
    """
    values = settings["scene"]
    names = (settings["seed"], values["volunteer"], values["side"], "scenes")
    breast = read_breast(files, settings["gravity"], side=values["side"], names=names)
    kept = {name: files_of(name, files["made"]) for name in STORED}
    chain = Chain(breast, settings["settings"], frozenset(effects), PRODUCTS)
    return chain.given({name: STORED[name].read(paths) for name, paths in kept.items() if paths})
