"""Equilibrium steps with the pressures as unknowns, by GMRES under a block triangular preconditioner.

[[K, B^T], [B, -M]] (x, q) = (b, 0), which is (K + B^T M^-1 B) x = b. With V, the V-cycle of K, and the Schur
complement M + B K^-1 B^T, which is about (1 + softness) M, the preconditioner is

    q = -((1 + softness) M)^-1 r_p,  x = V (r_u - B^T q)

Its iterations grow neither with refinement nor with the stiffness M^-1 (Elman, Silvester & Wathen 2014).
"""

import numpy as np
from scipy import sparse

from mammosim.mechanics.multigrid import VCycle
from mammosim.mechanics.pattern import Constraint, block_entries

# Directions that GMRES keeps before it starts anew from the residual.
RESTART = 60


class SaddlePoint:
    """The system of a prepared V-cycle and a constraint; held (n_node, 3) bool stays zero.

    Vectors and held are in the order of the rows of K: row i is of node order[i].
    """

    def __init__(self, cycle: VCycle, constraint: Constraint, order: np.ndarray, held: np.ndarray) -> None:
        self._cycle = cycle
        B = constraint.B.tocsc()[:, block_entries(order)]
        self._B = (B @ sparse.diags((~held).ravel().astype(float))).tocsr()
        self._BT = self._B.T.tocsr()
        self._M, self._factors = constraint.M, constraint.factors
        self._schur = 1 / (1 + constraint.softness)
        # Volumes left over, r_p, count as the forces that they would cause: about |B_v| / M_vv each.
        weight = np.sqrt(self._B.multiply(self._B).sum(axis=1).A1) / self._M.diagonal()
        # A cell that is held all over has no volume left over: any weight does.
        self._weight = np.where(weight > 0, weight, 1.0)
        self._n = held.size

    def solve(self, b: np.ndarray, tolerance: float, most: int) -> tuple[np.ndarray | None, int]:
        """x (n_node, 3) with |(K + B^T M^-1 B) x - b| <= tolerance |b|, or None, after `most` iterations."""
        x, r = np.zeros_like(b), b
        q = np.zeros(len(self._weight))
        done, enough = 0, tolerance * _norm(b)
        while done < most:
            r_p = self._M @ q - self._B @ x.ravel()
            start = np.concatenate([(r - (self._BT @ q).reshape(r.shape)).ravel(), self._weight * r_p])
            dx, dq, steps = self._gmres(start, 0.5 * enough, min(RESTART, most - done))
            x, q, done = x + dx, q + dq, done + steps
            r = b - self._cycle.times(x)
            stiff = self._BT @ self._factors.solve(self._B @ x.ravel())
            if _norm(r.ravel() - stiff) <= enough:
                return x, done
        return None, done

    def _times(self, x: np.ndarray, q: np.ndarray) -> np.ndarray:
        forces = self._cycle.times(x).ravel() + self._BT @ q
        return np.concatenate([forces, self._weight * (self._B @ x.ravel() - self._M @ q)])

    def _preconditioned(self, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q = -self._schur * self._factors.solve(r[self._n :] / self._weight)
        return self._cycle((r[: self._n] - self._BT @ q).reshape(-1, 3)), q

    def _gmres(self, r: np.ndarray, enough: float, most: int) -> tuple[np.ndarray, np.ndarray, int]:
        """(x, q) that lowers the residual r to `enough`, and how many steps it took; right-preconditioned."""
        beta = _norm(r)
        basis, H = [r / beta], np.zeros((most + 1, most))
        y = np.zeros(0)
        for k in range(most):
            w = self._times(*self._preconditioned(basis[k]))
            for i, v in enumerate(basis):
                H[i, k] = np.sum(v * w)
                w -= H[i, k] * v
            H[k + 1, k] = _norm(w)
            target = np.concatenate([[beta], np.zeros(k + 1)])
            y = np.linalg.lstsq(H[: k + 2, : k + 1], target)[0]
            if _norm(H[: k + 2, : k + 1] @ y - target) <= enough or H[k + 1, k] == 0:
                break
            basis.append(w / H[k + 1, k])
        combined = sum((c * v for c, v in zip(y, basis)), np.zeros_like(r))
        return *self._preconditioned(combined), len(y)


def _norm(a: np.ndarray) -> float:
    return float(np.sqrt(np.sum(a * a)))
