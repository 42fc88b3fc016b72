"""One breast of 60 mm on a piece of chest, coarse enough that its whole chain takes seconds."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from mammosim.chain.breast import Breast
from mammosim.chain.graph import Chain, overridden
from mammosim.chain.images import Moved
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import LabelMap, grid_around

CENTRE = np.array([55.0, 0.0, 0.0])
STREAMS = (1, "woman", "left")  # of random numbers: seed, volunteer and side
COARSE = {
    "mesh": {"element_mm": {"breast": 16.0, "chest": 26.0}},
    "compression": {"steps": 4, "chest_gap_mm": 14.0},
    "xray": {
        "energies": 4,
        "voxel_mm": 4.0,
        "pixel_mm": 3.0,
        "dose_error_percent": 10.0,
        "scatter_error_percent": 30.0,
        "scatter_pixel_mm": 30.0,
        "lesion": {"diameter_mm": 16.0, "depth_mm": 20.0},
        "calcifications": {"pixel_mm": 0.4, "images": 5},
        "tomosynthesis": {"pixel_mm": 5.0, "slice_mm": 6.0},
    },
}
THICKNESS_MM = 50.0


def small_labels() -> LabelMap:
    """Half an ellipsoid of fat with gland in it, on a slab of fat and muscle held at its sides and behind."""
    grid = grid_around(np.array([-2.0, -72.0, -62.0]), np.array([112.0, 34.0, 62.0]), 4.0)
    p = grid.centres().reshape(*grid.shape, 3)
    x, y, z = np.moveaxis(p, -1, 0)
    values = np.zeros(grid.shape, np.uint8)
    values[(y > 0) | _within(p, 42.0, 60.0)] = Label.ADIPOSE
    values[_within(p, 26.0, 44.0)] = Label.GLANDULAR
    values[y > 10] = Label.MUSCLE
    values[(y > 18) | ((y > 0) & ((x < 6) | (x > 104) | (np.abs(z) > 56)))] = Label.THORAX
    return LabelMap(grid, values)


def _within(p: np.ndarray, across_mm: float, deep_mm: float) -> np.ndarray:
    return (((p - CENTRE) / [across_mm, deep_mm, across_mm]) ** 2).sum(axis=-1) < 1


def small_breast() -> Breast:
    """Prone; its common frame is turned by 4 degrees about y and moved."""
    a = np.radians(4.0)
    turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    fiducials = Fiducials(
        ("chest_1", "chest_2", "chest_3", "chest_4", "nipple_left"),
        ("chest",) * 4 + ("nipple",),
        np.array([[10, 0, -54], [10, 0, 54], [100, 0, -54], [100, 0, 54], [55, -60, 0]], float),
    )
    motion = RigidTransform(turn, np.array([1.0, 2.0, -3.0]))
    return Breast(small_labels(), fiducials, motion, motion.R @ [0.0, -1.0, 0.0], "left")


def study_settings(repository: Path) -> dict[str, Any]:
    """The tiny study's configuration, coarser still, with tissues and the standard strategy."""
    config = _yaml(repository / "config/default.yaml")
    for other in (_yaml(repository / "config/smoke.yaml"), COARSE):
        config = overridden(config, other)
    strategy = _yaml(repository / "config/strategies.yaml")["standard"]
    tissues = _yaml(repository / "config/tissues/standard.yaml")
    load = {"position": "upright", "thickness_mm": THICKNESS_MM, "strategy": strategy}
    load |= {"moduli": "gravity", "tissues": tissues}
    return config | {"tissues": tissues, "load": load}


def _yaml(path: Path) -> dict[str, Any]:
    return yaml.safe_load(path.read_text())


def small_chain(repository: Path, *, without: tuple[str, ...] = (), also: tuple[str, ...] = ()) -> Chain:
    """The chain of the small breast with the study's effects, but for some, and others."""
    settings, breast = study_settings(repository), small_breast()
    moved = Moved(breast.to_reference, pd.DataFrame())
    effects = {*settings["mechanics"]["effects"], *settings["xray"]["effects"], *also} - {*without}
    given = {"labels": breast.labels, "fiducials": breast.fiducials, "transform": moved}
    return Chain(Subject("left", "0 -1 0", STREAMS), settings, frozenset(effects), STAGES).given(given)
