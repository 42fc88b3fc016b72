"""How the whole body lies in the scanner: one rigid motion per position, scanner = motion(body)."""

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.positions import gravity_direction
from mammosim.core.rigid import RigidTransform
from mammosim.core.rng import generator


def motion(
    position: str, *, largest_deg: float, largest_mm: float, stream: tuple[str | int, ...]
) -> RigidTransform:
    """The motion from the body frame into the scanner frame of a position, drawn from its named stream.

    The rotation, by half to all of largest_deg, has any axis through the origin; the shift is half to all of
    largest_mm.
    """
    # ASSUME: between positions the rib cage moves rigidly, by a drawn angle and shift; nobody breathes.
    rng = generator(*stream, "motion", position)
    axis, shift = rng.normal(size=(2, 3))
    angle = rng.uniform(0.5, 1) * np.radians(largest_deg)
    length = rng.uniform(0.5, 1) * largest_mm
    R = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    return RigidTransform(R, length * shift / np.linalg.norm(shift))


def gravity_in_body(position: str, moved: RigidTransform) -> np.ndarray:
    """g_body = R^T g_scanner (3,): gravity is known in the scanner, the body lies turned in it."""
    return moved.R.T @ gravity_direction(position)
