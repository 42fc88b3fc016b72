"""SART by itk-rtk: Joseph's projector forwards, and backwards the same (`joseph`) or by voxels (`voxels`)."""

import sys

import itk
import numpy as np
from _adapter import XrayTask, run
from itk import RTK as rtk

IMAGE = itk.Image[itk.F, 3]
BACK = {"joseph": "BP_JOSEPH", "voxels": "BP_VOXELBASED"}


class ItkRtk:
    """Source and detector in coordinates about the middle of the slices."""

    def __init__(self, problem: XrayTask) -> None:
        facts, d = problem.facts, problem.facts["detector"]
        shape, spacing = np.array(facts["shape"]), np.array(facts["spacing_mm"])
        half = spacing * (shape[::-1] - 1) / 2
        middle = np.array(facts["origin_mm"]) + half
        self.geometry = rtk.ThreeDCircularProjectionGeometry.New()
        for source in problem.arrays["sources"]:
            places = (itk.Point[itk.D, 3]((p - middle).tolist()) for p in (source, np.array(d["origin"])))
            axes = (itk.Vector[itk.D, 3](d[name]) for name in ("u", "v"))
            self.geometry.AddProjection(*places, *axes)
        self.views = itk.image_from_array(problem.arrays["integrals"])
        self.views.SetSpacing([d["pixel_mm"], d["pixel_mm"], 1.0])
        self.empty = itk.image_from_array(np.zeros(shape, np.float32))
        self.empty.SetSpacing(spacing.tolist())
        self.empty.SetOrigin((-half).tolist())
        self.iterations, self.relaxation = facts["iterations"], problem.settings["relaxation"]

    def solve(self) -> "itk.Image":
        sart = rtk.SARTConeBeamReconstructionFilter[IMAGE, IMAGE].New()
        sart.SetInput(0, self.empty)
        sart.SetInput(1, self.views)
        sart.SetGeometry(self.geometry)
        sart.SetForwardProjectionFilter(type(sart).ForwardProjectionType_FP_JOSEPH)
        sart.SetBackProjectionFilter(getattr(type(sart), f"BackProjectionType_{BACK[sys.argv[5]]}"))
        sart.SetNumberOfIterations(self.iterations)
        sart.SetNumberOfProjectionsPerSubset(1)
        sart.SetLambda(self.relaxation)
        sart.SetDisableDisplacedDetectorFilter(True)
        sart.Update()
        return sart.GetOutput()

    def answer(self, solved: "itk.Image") -> dict:
        return {"slices": itk.array_from_image(solved)}


if __name__ == "__main__":
    run(XrayTask, ItkRtk)
