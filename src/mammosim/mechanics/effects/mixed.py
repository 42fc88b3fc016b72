"""Nearly incompressible bulk tissue: neo-Hookean, its volume held by a continuous pressure.

W = mu/2 (I1bar - 3) + k'/2 (J - 1)^2 + (k - k')/2 (Pi J - 1)^2,  k' = min(k, c mu)

Pi projects on the functions that are continuous and linear in every tissue (L2, reference volume). With the
pressure p = (k - k') (Pi J - 1) = sum_v p_v N_v of quadratic tetrahedra this is the element of Taylor & Hood:

M p = b,  b_v = integral of N_v (J - 1),  M_vw = integral of N_v N_w / (k - k'),  E = b . p / 2
dE = sum_v p_v dJ_v, dJ_v = B dx,  B_va = integral of N_v C dN_a/dX,  d2E = p . d2J + B^T M^-1 B
"""

# ASSUME: where k <= c mu (nu <= 0.4516) volume is held at four points a cell, above by a continuous pressure.

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissues
from mammosim.mechanics.effects.bulk import NeoHookean
from mammosim.mechanics.effects.bulk_kernels import volume_gradients
from mammosim.mechanics.pattern import Constraint, Tangent, add_to_nodes
from mammosim.mechanics.reference import TETRAHEDRON_POINTS

# c: displacement-only elements lose nothing up to this k / mu (decisions/mechanics_incompressible.md).
POINTWISE_RATIO = 10.0
N = TETRAHEDRON_POINTS  # (4, 4): N_v at the integration points is their barycentric coordinates


@dataclass(frozen=True)
class PressureSpace:
    """Pressures at the vertices of the cells `held` (n_held,), the numbers of those whose volume they hold.

    unknowns (n_held, 4): the number of a cell's p_v, one for each vertex and tissue; volumes (n_held, 4) mm3
    of the integration points; M (n_p, n_p) mm3/kPa with its factors; softness (n_p,), see Constraint. B has
    the pairs of pressures and nodes `row_start`, `nodes`; entry: which of them a cell's (v, a) is.
    """

    held: np.ndarray
    unknowns: np.ndarray
    volumes: np.ndarray
    M: sparse.csr_matrix
    factors: SuperLU
    softness: np.ndarray
    entry: np.ndarray
    row_start: np.ndarray
    nodes: np.ndarray

    @classmethod
    def of(cls, mesh: TetMesh, pointwise: NeoHookean, k: np.ndarray) -> "PressureSpace":
        """For the cells where k - k' is positive, k (n_cell,) kPa and k' of the pointwise law."""
        stiffness = k - pointwise.k
        held = np.flatnonzero(stiffness > 0)
        cells, volumes, stiffness = mesh.cells[held], pointwise.quadrature.volumes[held], stiffness[held]
        n_node = len(mesh.points)
        layer = np.unique(mesh.tissue[held], return_inverse=True)[1]
        vertices = cells[:, :4] + n_node * layer[:, None]
        unknowns = np.unique(vertices, return_inverse=True)[1].reshape(-1, 4)
        n_p = int(unknowns.max()) + 1
        Me = np.einsum("eq,qv,qw->evw", volumes / stiffness[:, None], N, N)
        places = (np.repeat(unknowns, 4, axis=1).ravel(), np.tile(unknowns, 4).ravel())
        M = sparse.coo_matrix((Me.ravel(), places), (n_p, n_p)).tocsr()
        factors = splu(M.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        softness = np.empty(n_p)
        softness[unknowns] = (stiffness / (pointwise.k + 4 / 3 * pointwise.mu)[held])[:, None]
        keys, entry = np.unique(unknowns[:, :, None] * n_node + cells[:, None, :], return_inverse=True)
        row_start = np.searchsorted(keys // n_node, np.arange(n_p + 1))
        return cls(held, unknowns, volumes, M, factors, softness, entry.ravel(), row_start, keys % n_node)

    def pressure(self, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """p (n_p,) kPa, and b (n_p,) mm3, of J - 1 at the points of all cells, change (n_cell, 4)."""
        be = np.einsum("eq,qv->ev", self.volumes * change[self.held], N)
        b = np.bincount(self.unknowns.ravel(), weights=be.ravel())
        return self.factors.solve(b), b

    def at_points(self, p: np.ndarray, n_cell: int) -> np.ndarray:
        """The pressures (n_cell, 4) kPa at the points of all cells: zero in those not held."""
        there = np.zeros((n_cell, 4))
        there[self.held] = np.einsum("ev,qv->eq", p[self.unknowns], N)
        return there

    def constraint(self, Be: np.ndarray, n_node: int) -> Constraint:
        """B and M, of the cells' Be (n_held, 4, 10, 3); summed in the order of the cells."""
        blocks = np.stack([np.bincount(self.entry, weights=Be[..., i].ravel()) for i in range(3)], axis=1)
        B = sparse.bsr_matrix(
            (blocks[:, None, :], self.nodes, self.row_start), (len(self.row_start) - 1, 3 * n_node)
        )
        return Constraint(B.tocsr(), self.M, self.factors, self.softness)


@dataclass(frozen=True)
class MixedNeoHookean:
    """The elastic energy of all cells: pointwise with k', space with the rest.

    pressure (n_p,) kPa: p of the tangent if predicted.
    """

    pointwise: NeoHookean
    space: PressureSpace
    pressure: np.ndarray | None = None

    @classmethod
    def of(cls, mesh: TetMesh, tissues: Tissues) -> "MixedNeoHookean":
        """The cells of a mesh whose points are the reference.

        Raises MechanicsError for an unknown tissue, or when no tissue has k > c mu.
        """
        return cls.holding(mesh, NeoHookean.of(mesh, tissues))

    @classmethod
    def holding(cls, mesh: TetMesh, whole: NeoHookean) -> "MixedNeoHookean":
        """The same law as `whole`, the pointwise one of a mesh; see `of`."""
        pointwise = whole.softened(POINTWISE_RATIO)
        if np.all(whole.k == pointwise.k):
            largest = (whole.k / whole.mu).max()
            raise MechanicsError(
                f"k / mu is {largest:.3g} at most, not above {POINTWISE_RATIO:g}: nothing is left to the "
                "pressures; use NeoHookean, or bulk_tissue, which chooses"
            )
        return cls(pointwise, PressureSpace.of(mesh, pointwise, whole.k))

    @property
    def cells(self) -> np.ndarray:
        """(n_cell, 10)."""
        return self.pointwise.cells

    @property
    def mu(self) -> np.ndarray:
        """(n_cell,) kPa."""
        return self.pointwise.mu

    @property
    def connectivity(self) -> np.ndarray:
        """The cells."""
        return self.cells

    def energy(self, x: np.ndarray) -> float:
        """The integral of W; infinite where J <= 0 at an integration point."""
        p, b = self.space.pressure(self.pointwise.volume_ratios(x) - 1)
        return self.pointwise.energy(x) + 0.5 * float(np.sum(b * p))

    def energies(self, x: np.ndarray) -> np.ndarray:
        """The share (n_cell,) of each cell in the energy: b . p / 2 is a sum over the cells, too."""
        change = self.pointwise.volume_ratios(x) - 1
        p, _ = self.space.pressure(change)
        held = np.zeros_like(change)
        held[self.space.held] = self.space.volumes * change[self.space.held]
        E: np.ndarray = self.pointwise.energies(x) + 0.5 * np.sum(
            held * self.space.at_points(p, len(change)), axis=1
        )
        return E

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of P dN_a/dX, P under both pressures."""
        add_to_nodes(self.cells, self.cell_forces(x), g)

    def cell_forces(self, x: np.ndarray) -> np.ndarray:
        """Of each cell on its nodes (n_cell, 10, 3) mN: what add_gradient adds up."""
        change = self.pointwise.volume_ratios(x) - 1
        p, _ = self.space.pressure(change)
        local = self.pointwise.k[:, None] * change
        return self.pointwise.cell_forces_under(x, local + self.space.at_points(p, len(self.cells)))

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of dN_a/dX . d2W/dF2 . dN_b/dX at given p, and the constraint (B, M)."""
        p = self.pressure
        if p is None:
            p, _ = self.space.pressure(self.pointwise.volume_ratios(x) - 1)
        total = self.pointwise.tangent_pressure(x) + self.space.at_points(p, len(self.cells))
        self.pointwise.add_tangent_under(x, total, K, projected=projected)
        q, held = self.pointwise.quadrature, self.space.held
        Be = volume_gradients(x, self.cells[held], q.gradients[held], q.volumes[held], N)
        K.constraint = self.space.constraint(Be, len(x))

    def smallest_J(self, x: np.ndarray) -> float:
        """The smallest J of the integration points."""
        return self.pointwise.smallest_J(x)

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> "MixedNeoHookean":
        """The law with the pressures that the step predicts, M p = b + B dx; see NeoHookean.predicted."""
        p, _ = self.space.pressure(self.pointwise.predicted_changes(x, dx))
        return replace(self, pointwise=self.pointwise.predicted(x, dx), pressure=p)


def bulk_tissue(mesh: TetMesh, tissues: Tissues) -> NeoHookean | MixedNeoHookean:
    """The cheaper law that holds the volume of all tissues. Raises MechanicsError for an unknown tissue."""
    whole = NeoHookean.of(mesh, tissues)
    suffices = np.all(whole.k <= POINTWISE_RATIO * whole.mu)
    return whole if suffices else MixedNeoHookean.holding(mesh, whole)
