"""Removing the slow variation of brightness that receiver coils leave."""

import numpy as np
import SimpleITK as sitk

from mammosim.core.volume import Image
from mammosim.io.images import itk_volume

# The bias field is smooth, so that it is estimated on voxels of about this size.
COARSE_MM = 6.0
ITERATIONS = (30, 30)


def correct_bias(image: Image, body: np.ndarray) -> Image:
    """The image over its bias field, estimated by N4 (Tustison et al. 2010) in body (nz, ny, nx) bool."""
    volume = itk_volume(image.grid, image.values.astype(np.float32) + 1.0)  # N4 takes the logarithm
    mask = itk_volume(image.grid, body.astype(np.uint8))
    factors = [max(1, round(COARSE_MM / h)) for h in image.grid.spacing]
    n4 = sitk.N4BiasFieldCorrectionImageFilter()
    n4.SetNumberOfThreads(1)
    n4.SetMaximumNumberOfIterations(ITERATIONS)
    n4.Execute(sitk.Shrink(volume, factors), sitk.Shrink(mask, factors))
    field = np.exp(sitk.GetArrayFromImage(n4.GetLogBiasFieldAsImage(volume)))
    return Image(image.grid, (image.values / field).astype(np.float32))
