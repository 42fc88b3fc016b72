"""One view by gecatsim: its compiled distance-driven projector, and numpy's exponentials in single precision.

Voxels and materials are handed over before, as `setup_s`. The projector returns lengths in each material;
from there to the image, rays go in groups that stay in the cache.
"""

import sys
from pathlib import Path

import numpy as np
from _adapter import XrayTask, run

# Of what mammosim needs, this Python has numpy alone.
sys.path.insert(0, str(Path(__file__).parents[3] / "src"))
from mammosim.xray.catsim_library import Flat, Voxels, load, project

ROWS = 8  # of pixels at a time


class Gecatsim:
    def __init__(self, problem: XrayTask) -> None:
        facts, index = problem.facts, problem.arrays["index"]
        spacing, d = np.array(facts["spacing_mm"]), facts["detector"]
        size = spacing * (np.array(index.shape[::-1]) - 1)
        n_material = len(facts["materials"]) - 1
        self.voxels = Voxels(index, np.array(facts["origin_mm"]) + size / 2, spacing, np.eye(n_material))
        across = d["pixel_mm"] * (np.array(d["shape"]) - 1) / 2
        middle = np.array(d["origin"]) + across[1] * np.array(d["u"]) + across[0] * np.array(d["v"])
        self.view = Flat(np.array(facts["source_mm"]), middle, tuple(d["shape"]), d["pixel_mm"])
        mu = problem.arrays["mu"]
        self.more = (mu[1:] - mu[0]).astype(np.float32)
        r, h = problem.from_source()
        self.r, self.mu_air = r.astype(np.float32), mu[0].astype(np.float32)
        self.share, self.weights = h / r**3, problem.arrays["weights"].astype(np.float32)
        load(self.voxels)

    def solve(self) -> np.ndarray:
        lengths = project(self.voxels, self.view, last=False)
        image = np.empty(lengths.shape[:2])
        for first in range(0, len(image), ROWS):
            rows = slice(first, first + ROWS)
            depth = lengths[rows] @ self.more
            depth += self.r[rows, :, None] * self.mu_air
            np.negative(depth, out=depth)
            np.exp(depth, out=depth)
            image[rows] = depth @ self.weights
        return image * self.share

    def answer(self, solved: np.ndarray) -> dict:
        return {"image": solved}


if __name__ == "__main__":
    run(XrayTask, Gecatsim)
