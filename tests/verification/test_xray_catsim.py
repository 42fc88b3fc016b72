"""Primary images of gecatsim, where it is installed, and ours."""

import importlib.util

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, gaussian_filter

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.catsim import primary_by_catsim
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import primary
from mammosim.xray.spectrum import Spectrum

INSTALLED = importlib.util.find_spec("gecatsim") is not None
X, Y, _ = np.eye(3)
BEAM = Spectrum(np.array([15.0, 20.0, 25.0]), np.array([1e5, 2e5, 1e5]), 650.0)


def breast() -> Phantom:
    """60 x 50 x 30 mm with blobs of two tissues."""
    grid = grid_around(np.array([-30.0, -50.0, 20.0]), np.array([30.0, 0.0, 50.0]), (1.0, 0.8, 1.0))
    blobs = gaussian_filter(generator(6, "blobs").standard_normal(grid.shape), 2) > 0
    tissues = (material("air"), material("adipose"), material("glandular"))
    return Phantom(grid, (1 + blobs).astype(np.uint8), tissues)


def view(u: np.ndarray, v: np.ndarray) -> Geometry:
    """360 x 300 pixels of 0.2 mm centred below the breast, the source aside."""
    centre = np.array([0.0, -26.0, 0.0])
    origin = centre - 0.2 * (179.5 * u + 149.5 * v)
    return Geometry(np.array([40.0, 5.0, 640.0]), Detector(origin, u, v, (300, 360), 0.2))


@pytest.mark.skipif(not INSTALLED, reason="gecatsim is an optional extra")
@pytest.mark.parametrize("axes", [(X, Y), (-X, -Y)], ids=["forwards", "backwards"])
def test_gecatsim_and_our_rays_give_the_same_image(axes):
    """Inside, away from the edges of the body, where lengths hardly vary within a pixel of 0.2 mm.

    Theirs is the image of the mean length, ours the mean of 3 x 3 images: less by half the variance of the
    depth in a pixel, some 1e-4, as voxels of 1 mm differ by 0.02.
    """
    of = breast(), view(*axes), BEAM
    theirs, ours = primary_by_catsim(*of), primary(*of, supersampling=3)
    np.testing.assert_allclose(theirs.unobstructed, ours.unobstructed, rtol=1e-5)
    inside = binary_erosion(ours.signal < 0.6 * ours.unobstructed, iterations=12)
    ratio = (theirs.signal / ours.signal)[inside]
    assert inside.mean() > 0.4
    assert ratio.mean() == pytest.approx(1.0, abs=2e-4)
    assert ratio.std() < 2e-3


def test_without_gecatsim_its_absence_is_told_and_what_it_cannot_do_is_rejected():
    if not INSTALLED:
        with pytest.raises(XrayError, match=r"install mammosim\[peers\]"):
            primary_by_catsim(breast(), view(X, Y), BEAM)
    turned = np.array([0.8, 0.6, 0.0]), np.array([-0.6, 0.8, 0.0])
    with pytest.raises(XrayError, match="along x and y"):
        primary_by_catsim(breast(), view(*turned), BEAM)
