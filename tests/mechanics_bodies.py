"""Simple bodies for the tests of the mechanics, and where to look on them."""

import numpy as np

from mammosim.meshing.shapes import ball_part as sphere_part
from mammosim.meshing.shapes import box

__all__ = ["box", "nearest", "sphere_part"]


def nearest(mesh, point):
    """The node nearest to a point (3,)."""
    return int(np.argmin(np.linalg.norm(mesh.points - point, axis=1)))
