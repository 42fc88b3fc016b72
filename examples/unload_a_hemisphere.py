"""A hemisphere of fat that hangs from its base: its shape without gravity, and that shape loaded again."""

import numpy as np

import mammosim as ms
from mammosim.meshing.shapes import ball_part

hanging = ball_part(50.0, 14.0)  # as measured: its base, held, in z = 0
down = np.array([0.0, 0.0, 1.0])  # away from the base
fat = ms.Tissue(youngs_modulus_kpa=2.0, poisson_ratio=0.45, density_g_cm3=0.95)
body = ms.Body({ms.Label.ADIPOSE: fat})

rest = ms.inverse(hanging, body, gravity=down).points
again = body.load(hanging.moved_to(rest), down).points

print(f"gravity had moved its lowest point by {np.ptp(hanging.points[:, 2]) - np.ptp(rest[:, 2]):.2f} mm")
print(f"loaded again it is {np.abs(again - hanging.points).max():.1e} mm from where it was measured")
