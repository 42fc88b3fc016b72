"""One breast of one's own, labelled, from its voxels to force, dose and contrast: the chain of the study."""

from pathlib import Path

import numpy as np
import yaml

import mammosim as ms
from mammosim.chain.graph import overridden
from mammosim.core.volume import grid_around

CONFIG = Path(__file__).parents[1] / "config"


def read(name: str) -> dict:
    return yaml.safe_load((CONFIG / name).read_text())


# Yours would be ms.read_labels("labels.nii.gz"), scanned prone: frame LPS, mm, the nipple points to -y.
grid = grid_around(np.array([-2.0, -72.0, -62.0]), np.array([112.0, 34.0, 62.0]), 4.0)
x, y, z = np.moveaxis(grid.centres().reshape(*grid.shape, 3), -1, 0)
r = np.sqrt(((x - 55) / 42) ** 2 + (y / 60) ** 2 + (z / 42) ** 2)
values = np.where((y > 0) | (r < 1), ms.Label.ADIPOSE, ms.Label.AIR)
values[r < 0.65] = ms.Label.GLANDULAR
values[y > 10] = ms.Label.MUSCLE
values[(y > 18) | ((y > 0) & ((x < 6) | (x > 104) | (abs(z) > 56)))] = ms.Label.THORAX
labels = ms.LabelMap(grid, values.astype(np.uint8))
corners = [[10, 0, -54], [10, 0, 54], [100, 0, -54], [100, 0, 54]]  # the piece of chest that is modelled
fiducials = ms.Fiducials(
    ("chest_1", "chest_2", "chest_3", "chest_4", "nipple_left"),
    ("chest", "chest", "chest", "chest", "nipple"),
    np.array([*corners, [55, -60, 0]], float),
)

settings = overridden(read("default.yaml"), read("smoke.yaml"))
tissues, strategies = read("tissues/standard.yaml"), read("strategies.yaml")
load = {"moduli": "gravity", "tissues": tissues, "thickness_mm": 50.0, "strategy": strategies["standard"]}
settings |= {"tissues": tissues, "load": load}
effects = frozenset(settings["mechanics"]["effects"] + settings["xray"]["effects"])
woman = ms.Subject(side="left", gravity="0 -1 0", streams=(1, "mine", "left"), moves=False)
chain = ms.Chain(woman, settings, effects, ms.STAGES).given({"labels": labels, "fiducials": fiducials})

print(f"{chain['pressed'].row['force_n']:.2f} N at {chain['pressed'].row['plates_mm']:.0f} mm")
print(f"{chain['exposed_dose'].dose_mgy:.2f} mGy, CNR {chain['mammogram'].row['cnr_quantum']:.1f}")
