"""Rigid motion of 3D points, in the patient frame LPS, mm."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RigidTransform:
    """y = R x + t for points (n, 3); R (3, 3) a rotation, t (3,) in mm."""

    R: np.ndarray
    t: np.ndarray

    def __post_init__(self) -> None:
        if not np.allclose(self.R @ self.R.T, np.eye(3), atol=1e-8) or np.linalg.det(self.R) < 0:
            raise ValueError("R is not a rotation: R R^T = 1 and det R = 1 are required")

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Moved points (n, 3)."""
        y: np.ndarray = points @ self.R.T + self.t
        return y

    def inverse(self) -> "RigidTransform":
        """x = R^T (y - t)."""
        return RigidTransform(self.R.T, -self.R.T @ self.t)

    def after(self, first: "RigidTransform") -> "RigidTransform":
        """The motion that does `first`, then this one."""
        return RigidTransform(self.R @ first.R, self.R @ first.t + self.t)

    @property
    def angle_deg(self) -> float:
        """Angle of the rotation."""
        return float(np.degrees(np.arccos(np.clip((np.trace(self.R) - 1) / 2, -1, 1))))


IDENTITY = RigidTransform(np.eye(3), np.zeros(3))


def rotation(angles_deg: np.ndarray) -> np.ndarray:
    """R = Rz Ry Rx of the angles (3,) about the x, y and z axes, in degrees."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(angles_deg)), np.sin(np.radians(angles_deg))
    Rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    Ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    Rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    R: np.ndarray = Rz @ Ry @ Rx
    return R
