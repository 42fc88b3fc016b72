"""Press a block of fat of 30 mm between two plates to 24 mm: force, contact area, and how far it bulges."""

import numpy as np

import mammosim as ms
from mammosim.meshing.shapes import box

mesh = box((3, 3, 3), (30.0, 30.0, 30.0), posterior_axis=1)  # held at y = 0
fat = ms.Tissue(youngs_modulus_kpa=1.0, poisson_ratio=0.45, density_g_cm3=0.95)
skin = ms.Skin(youngs_modulus_kpa=10.0, poisson_ratio=0.45, thickness_mm=1.45)
body = ms.Body({ms.Label.ADIPOSE: fat}, (skin,))

plates = ms.Plates(
    centre=np.array([15.0, 25.0, 15.0]),
    # Columns: out of the body, across, and up, from the support to the paddle.
    axes=np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    half_sizes=np.array([15.0, 25.0, 6.0]),
    edge_radius_mm=5.0,
)
found = ms.compress(mesh, body.effects(mesh), plates=plates, control=ms.Thickness(24.0))

last = found.path.iloc[-1]
bulge = float((found.points - mesh.points)[:, 1].max())
print(f"{last.force_n:.3f} N on {last.contact_area_mm2:.0f} mm2; it bulges by {bulge:.2f} mm")
