"""Where the markers are glued on the stress-free skin, and the nipples; body frame, LPS, mm."""

import numpy as np

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.digital.anatomy import Anatomy

# ASSUME: chest markers lie at the notch, below the right clavicle, beside the sternum, below the left breast.
CHEST_XZ_MM = ((0.0, 88.0), (-72.0, 84.0), (10.0, 58.0), (88.0, -89.0))
# ASSUME: three markers lie on the lower half of each breast, at these angles from and round its axis.
BREAST_LEFT_DEG = ((58.0, -25.0), (38.0, -90.0), (62.0, -140.0))
BREAST_RIGHT_DEG = ((55.0, -40.0), (46.0, -100.0), (58.0, -155.0))
REACH_MM = 250.0


def skin_points(anatomy: Anatomy) -> Fiducials:
    """The ten markers and two nipples as points on the outer face of the skin.

    Raises FiducialError when the body reaches further than REACH_MM.
    """
    rays = [(np.array([x, 0.0, z]), np.array([0.0, -1.0, 0.0])) for x, z in CHEST_XZ_MM]
    for mound, three in zip(anatomy.mounds, (BREAST_LEFT_DEG, BREAST_RIGHT_DEG)):
        rays += [(mound.centre, _direction(mound.axes, *angles)) for angles in three]
    worn = _on_skin(anatomy, *map(np.array, zip(*rays)))
    nipples = [mound.nipple for mound in anatomy.mounds]
    names = [*(f"chest_{i}" for i in range(1, 5)), *(f"breast_{i}" for i in range(1, 7))]
    return Fiducials(
        (*names, "nipple_left", "nipple_right"),
        ("chest",) * 4 + ("breast",) * 6 + ("nipple",) * 2,
        np.array([*worn, *nipples]),
    )


def skin_normals(anatomy: Anatomy, points: np.ndarray) -> np.ndarray:
    """Outward unit normals (n, 3) of the skin at points (n, 3), along the gradient of the outer field."""
    h = 0.1
    steps = h * np.eye(3)
    n = np.stack([anatomy.outer_field(points + e) - anatomy.outer_field(points - e) for e in steps], axis=1)
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def _direction(axes: np.ndarray, polar_deg: float, round_deg: float) -> np.ndarray:
    u, v, d = axes
    outward = u if u[0] * d[0] > 0 else -u
    polar, turn = np.radians([polar_deg, round_deg])
    return np.cos(polar) * d + np.sin(polar) * (np.cos(turn) * outward + np.sin(turn) * v)


def _on_skin(anatomy: Anatomy, start: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Where rays (n, 3) from starts (n, 3) inside the body leave it, by bisection to 1e-6 mm."""
    inside, outside = np.zeros((len(start), 1)), np.full((len(start), 1), REACH_MM)
    if (anatomy.outer_field(start + outside * direction) < 0).any():
        raise FiducialError(
            f"the skin is further than {REACH_MM:g} mm from the chest; reduce the body's size"
        )
    while (outside - inside).max() > 1e-6:
        middle = (inside + outside) / 2
        within = anatomy.outer_field(start + middle * direction)[:, None] < 0
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    return start + inside * direction
