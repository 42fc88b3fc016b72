"""The ribs behind a measured breast: which faces of the boundary `posterior` lie on them, and their surface.

An elliptic cylinder of any direction is fitted by least squares of its signed distance, first to all faces
that are not cut across the body, then to those alone that lie on it and face it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import rotation
from mammosim.mechanics.effects import EllipticCylinder
from mammosim.mechanics.reference import faces_of

# ASSUME: the cuts above and below are within 35 degrees of the axial plane, and the ribs are not.
_CUT = np.cos(np.radians(35.0))
# ASSUME: what faces the fitted wall to 35 degrees and lies within 5 mm of it is on the ribs.
_FACING, _NEAR_MM = np.cos(np.radians(35.0)), 5.0
_MOST_DEG = 10.0  # that the wall is turned from the patient's axes


@dataclass(frozen=True)
class Ribs:
    """faces (n_face, 6) of the boundary `posterior` that lie on the wall; residual_mm: root mean square."""

    faces: np.ndarray
    wall: EllipticCylinder
    residual_mm: float


def ribs_of(mesh: TetMesh) -> Ribs:
    """Of a mesh in the patient's axes LPS. Raises MechanicsError where its back is no elliptic cylinder."""
    faces = faces_of(mesh, "posterior")
    middles, normals = _middles_and_normals(mesh.points, faces)
    on_ribs = np.abs(normals[:, 2]) < _CUT
    for _ in range(2):
        if on_ribs.sum() < 8:
            raise MechanicsError(
                f"{on_ribs.sum()} faces of what is held lie on an elliptic cylinder; the breast cannot slide "
                "on ribs of another shape: leave sliding and chest_wall out of the effects"
            )
        wall = _fitted(middles[on_ribs])
        facing = -np.sum(normals * wall.normal(middles), axis=1)
        on_ribs = (facing > _FACING) & (np.abs(wall.distance(middles)) < _NEAR_MM)
    residual = float(np.sqrt(np.mean(wall.distance(middles[on_ribs]) ** 2)))
    return Ribs(np.ascontiguousarray(faces[on_ribs]), wall, residual)


def _middles_and_normals(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of faces (n, 6), by their vertices: (n, 3) mm and outward unit vectors (n, 3)."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    n = np.cross(b - a, c - a)
    return (a + b + c) / 3, n / np.linalg.norm(n, axis=1, keepdims=True)


def _fitted(points: np.ndarray) -> EllipticCylinder:
    """The cylinder nearest to points (n, 3): centre in the axial plane, semi-axes, and two small turns."""
    width, front = np.ptp(points[:, 0]) / 2, points[:, 1].min()
    middle = points[:, [0, 2]].mean(axis=0)
    start = np.array([middle[0], front + width, width, width, 0.0, 0.0, 0.0])
    reach = 3 * width + np.ptp(points[:, 1])
    low = [middle[0] - width, front, width / 4, width / 4, *[-_MOST_DEG] * 3]
    high = [middle[0] + width, front + reach, reach, reach, *[_MOST_DEG] * 3]

    def wall(p: np.ndarray) -> EllipticCylinder:
        return EllipticCylinder(np.array([p[0], p[1], middle[1]]), p[2:4], rotation(p[4:]))

    scale = np.array([10.0, 10.0, 10.0, 10.0, 1.0, 1.0, 1.0])
    found = least_squares(
        lambda p: wall(p).distance(points), start, bounds=(low, high), x_scale=scale, loss="soft_l1"
    )
    return wall(found.x)
