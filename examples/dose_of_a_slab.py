"""Glandular dose of a slab of fat and gland, 40 mm thick, for photons of 20 keV, with its standard error."""

import numpy as np

import mammosim as ms
from mammosim.chain.mammogram import xray_phantom
from mammosim.core.volume import grid_around

grid = grid_around(np.array([-60.0, -80.0, 0.0]), np.array([60.0, 0.0, 40.0]), 4.0)
rng = np.random.default_rng(1)
# A fifth of the voxels, drawn at random, is gland.
values = np.where(rng.random(grid.shape) < 0.2, ms.Label.GLANDULAR, ms.Label.ADIPOSE).astype(np.uint8)
slab = ms.LabelMap(grid, values)

view = ms.mammography_geometry(xray_phantom(slab), chest_wall_y_mm=0.0, pixel_mm=5.0)
beam = ms.monoenergetic(20.0, fluence=1e5)  # photons per mm2 and mAs at 1 m
dose = ms.dose_in(slab, view, beam, relative_error=0.02, seed=7)

print(f"{1e3 * dose.mgy_per_mas:.3f} +- {1e3 * dose.standard_error_mgy_per_mas:.3f} uGy/mAs")
print(f"{dose.mgy_per_mgy:.3f} mGy per mGy of air kerma at the entrance")
