"""Region and scatter by mammosim's plain transport, without any of what lessens the variance.

So many photons are followed as the energy in all tissue needs for `tissue_error`; the time to the error asked
for follows from the error reached.
"""

import numpy as np
from _scene import EV_PER_KEV, scene_of
from _xray import Problem, run

from mammosim.xray.tally_result import Tallies
from mammosim.xray.transport import Accuracy, transport


class Plain:
    def __init__(self, problem: Problem) -> None:
        self.scene, self.facts, self.seed = scene_of(problem), problem.facts, 0
        self.asked = problem.arrays.get("asked")
        self.accuracy = Accuracy(self.facts["tissue"], problem.settings["tissue_error"])

    def solve(self) -> Tallies:
        self.seed += 1
        return transport(
            *(self.scene.phantom, self.scene.geometry, self.scene.spectrum),
            accuracy=self.accuracy,
            seed=self.seed,
            regions=np.array(self.facts["box_mm"])[None] if "box_mm" in self.facts else None,
            cell_mm=self.facts.get("cell_mm", 10.0),
        )

    def answer(self, solved: Tallies) -> dict:
        if self.asked is None:
            value, error = solved.regions.value, solved.regions.error
        else:
            value, error = solved.scatter.value[self.asked], solved.scatter.error[self.asked]
        seen = np.where(value > 0, value, np.nan)
        return {
            "histories": float(solved.histories),
            "value": EV_PER_KEV * float(value.sum()),
            "standard_error": EV_PER_KEV * float(np.sqrt(np.sum(error**2))),
            "reached": float(np.sqrt(np.mean((error / seen) ** 2))),
        }


if __name__ == "__main__":
    run(Plain)
