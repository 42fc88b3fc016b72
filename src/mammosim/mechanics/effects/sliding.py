"""Sliding: the back of the breast stays at its distance from the muscle, and moves along it.

E = 1/2 integral of eps (d(x) - d(X))^2 + kappa |T (x - X)|^2 over the reference area,  T = 1 - n(X) (x) n(X)

d is the signed distance of the wall, eps the stiffness against approaching or leaving it, kappa that of the
loose tissue along it: zero for free sliding.
"""

# ASSUME: the layer on which the breast slides is thin; it ties the breast to the wall in both directions.
# ASSUME: the loose tissue along the wall pulls back in proportion to the slip, in the plane where it began.

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.effects.contact import Obstacle
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import FACE_SHAPES, face_quadrature
from mammosim.mechanics.soundness import faces_of


@dataclass(frozen=True)
class Sliding(WithoutVolume):
    """faces (n_face, 6), reference areas (n_face, 6) mm2, points X (n_node, 3) mm; eps and kappa [kPa/mm].

    Raises MechanicsError for eps <= 0 or kappa < 0.
    """

    faces: np.ndarray
    areas: np.ndarray
    points: np.ndarray
    wall: Obstacle
    normal_stiffness: float
    tangential_stiffness: float = 0.0

    def __post_init__(self) -> None:
        if self.normal_stiffness <= 0 or self.tangential_stiffness < 0:
            raise MechanicsError(
                f"sliding with eps = {self.normal_stiffness:g} (above 0) and kappa = "
                f"{self.tangential_stiffness:g} (at least 0) kPa/mm"
            )

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        wall: Obstacle,
        *,
        normal_stiffness: float,
        tangential_stiffness: float = 0.0,
        boundary: str = "posterior",
    ) -> "Sliding":
        """The boundary of a mesh, whose points are the reference, slides on a wall.

        Nodes that slide must not be held: pass `held` to the equilibrium without them.
        Raises MechanicsError as the class does, and when the mesh has no such boundary.
        """
        faces = faces_of(mesh, boundary)
        areas = face_quadrature(mesh.points, faces).areas
        return cls(faces, areas, mesh.points, wall, normal_stiffness, tangential_stiffness)

    @property
    def connectivity(self) -> np.ndarray:
        """The faces."""
        return self.faces

    def _state(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """y (n, 3), the gap d(x) - d(X) (n,) and the slip T (x - X) (n, 3), n = 6 n_face."""
        y, Y = (positions(at, self.faces, FACE_SHAPES).reshape(-1, 3) for at in (x, self.points))
        u, n = y - Y, self.wall.normal(Y)
        return y, self.wall.distance(y) - self.wall.distance(Y), u - np.sum(u * n, axis=1)[:, None] * n

    def energy(self, x: np.ndarray) -> float:
        """E = 1/2 integral of eps gap^2 + kappa |slip|^2."""
        _, gap, slip = self._state(x)
        density = self.normal_stiffness * gap**2 + self.tangential_stiffness * np.sum(slip**2, axis=1)
        return float(np.sum(self.areas.ravel() * density)) / 2

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of (eps gap n(x) + kappa slip) N_a."""
        y, gap, slip = self._state(x)
        t = self.normal_stiffness * gap[:, None] * self.wall.normal(y) + self.tangential_stiffness * slip
        t = t.reshape(*self.areas.shape, 3) * self.areas[..., None]
        add_to_nodes(self.faces, gathered_forces(t, FACE_SHAPES), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of (eps (n (x) n + gap H) + kappa T) N_a N_b, without H when projected."""
        y, gap, _ = self._state(x)
        n, N = (
            self.wall.normal(y),
            self.wall.normal(positions(self.points, self.faces, FACE_SHAPES).reshape(-1, 3)),
        )
        M = n[:, :, None] * n[:, None, :]
        if not projected:
            M += gap[:, None, None] * self.wall.hessian(y)
        M *= self.normal_stiffness
        M += self.tangential_stiffness * (np.eye(3) - N[:, :, None] * N[:, None, :])
        M = M.reshape(*self.areas.shape, 3, 3) * self.areas[..., None, None]
        K.add(self.faces, gathered_stiffness(M, FACE_SHAPES))
