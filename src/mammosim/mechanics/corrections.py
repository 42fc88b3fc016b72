"""Corrections of a stress-free shape X, from d = x(X) - measured: at the nodes, pulled back, by the skin."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.mechanics.elastic import carried
from mammosim.mechanics.fixed_point import Guess
from mammosim.mechanics.reference import cell_quadrature


@dataclass(frozen=True)
class Nodal:
    """u = -d at every node (Carter 2009)."""

    def driven(self, measured: TetMesh) -> np.ndarray:
        """All nodes."""
        return np.arange(len(measured.points))

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm; d is zero where x is held."""
        return -guess.d


@dataclass(frozen=True)
class PulledBack(Nodal):
    """u = -F^-1 d, F = dx/dX: the difference carried back into the stress-free shape (Eiben 2014)."""

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm."""
        u: np.ndarray = -np.einsum("nij,nj->ni", nodal_inverses(guess.mesh, guess.x), guess.d)
        return u


@dataclass(frozen=True)
class SurfaceDriven:
    """u = -d at the nodes of the skin only, carried to those inside by an elastic transform."""

    def driven(self, measured: TetMesh) -> np.ndarray:
        """The nodes of the skin that are free."""
        return np.setdiff1d(measured.boundary_nodes("skin"), measured.boundary_nodes("posterior"))

    def __call__(self, guess: Guess) -> np.ndarray:
        """u (n_node, 3) mm."""
        mesh, u = guess.mesh, np.zeros_like(guess.d)
        skin = self.driven(mesh)
        u[skin] = -guess.d[skin]
        prescribed = np.zeros(len(u), dtype=bool)
        prescribed[skin] = prescribed[mesh.boundary_nodes("posterior")] = True
        return carried(mesh, u, prescribed)


def nodal_inverses(mesh: TetMesh, x: np.ndarray) -> np.ndarray:
    """F^-1 (n_node, 3, 3) of the shape x (n_node, 3), mesh.points the reference.

    At a node, the average of F^-1 over the reference volume of its cells.
    """
    quadrature = cell_quadrature(mesh.points, mesh.cells)
    F = np.einsum("eai,eqaj->eqij", x[mesh.cells], quadrature.gradients)
    sums = np.einsum("eq,eqij->eij", quadrature.volumes, np.linalg.inv(F))
    total, weight = np.zeros((len(x), 3, 3)), np.zeros(len(x))
    np.add.at(total, mesh.cells, sums[:, None])
    np.add.at(weight, mesh.cells, quadrature.volumes.sum(axis=1)[:, None])
    return total / weight[:, None, None]
