"""The problem solved by plain scikit-fem: its assembly, a textbook Newton, and symmetric PARDISO."""

import numpy as np
import skfem
from _adapter import Hemisphere, NotConverged, Path, in_load_steps, run
from pypardiso import PyPardisoSolver
from scipy.sparse import triu
from skfem.helpers import ddot, det, grad, identity, inv, mul, transpose

MAX_ITERATIONS = 30


def stress(w: dict) -> np.ndarray:
    """P = mu J^(-2/3) (F - I1/3 F^-T) + k (J - 1) J F^-T, with I1 = tr F^T F."""
    F = identity(w["u"].grad) + w["u"].grad
    J, G, mu, k = det(F), transpose(inv(F)), w["mu"], w["k"]
    with np.errstate(invalid="ignore"):
        return mu * J ** (-2 / 3) * (F - ddot(F, F) / 3 * G) + k * (J - 1) * J * G


@skfem.LinearForm
def residual(v: skfem.DiscreteField, w: dict) -> np.ndarray:
    return ddot(stress(w), grad(v)) - w["weight"] * v[2]


@skfem.BilinearForm
def tangent(du: skfem.DiscreteField, v: skfem.DiscreteField, w: dict) -> np.ndarray:
    """dP : grad v, with dF = grad du and dF^-T = -F^-T dF^T F^-T."""
    F, dF = identity(w["u"].grad) + w["u"].grad, grad(du)
    J, G, mu, k = det(F), transpose(inv(F)), w["mu"], w["k"]
    GdF, I1 = ddot(G, dF), ddot(F, F)
    dG = -mul(G, mul(transpose(dF), G))
    a = mu * J ** (-2 / 3)
    isochoric = -2 / 3 * GdF * (F - I1 / 3 * G) + dF - 2 / 3 * ddot(F, dF) * G - I1 / 3 * dG
    volumetric = (2 * J - 1) * J * GdF * G + (J - 1) * J * dG
    return ddot(a * isochoric + k * volumetric, grad(v))


class ScikitFem:
    """node_dofs (n_node, 3): the unknowns of each node."""

    def __init__(self, problem: Hemisphere) -> None:
        self.problem = problem
        self.mesh = skfem.MeshTet2(problem.points.T, problem.cells.T)

    def solve(self) -> Path:
        problem = self.problem
        basis = skfem.Basis(self.mesh, skfem.ElementVector(skfem.ElementTetP2()), intorder=2)
        self.node_dofs = np.empty(problem.points.shape, dtype=int)
        self.node_dofs[problem.cells] = basis.element_dofs.T.reshape(-1, 10, 3)
        free = basis.complement_dofs(self.node_dofs[problem.held].ravel())
        points = np.ones(len(basis.W))
        material = {"mu": np.outer(problem.mu, points), "k": np.outer(problem.k, points)}
        pardiso = PyPardisoSolver(mtype=-2)

        def fields(U: np.ndarray, factor: float) -> dict:
            return material | {"u": basis.interpolate(U), "weight": factor * problem.weight}

        enough = problem.tolerance * np.linalg.norm(
            residual.assemble(basis, **fields(basis.zeros(), 1.0))[free]
        )

        def step(U: np.ndarray, factor: float) -> tuple[np.ndarray, int]:
            for iteration in range(MAX_ITERATIONS):
                r = residual.assemble(basis, **fields(U, factor))[free]
                if not np.isfinite(r).all():
                    raise NotConverged("the residual is not finite", iteration)
                if np.linalg.norm(r) <= enough:
                    return U, iteration
                K = tangent.assemble(basis, **fields(U, factor))[free][:, free]
                U[free] -= pardiso.solve(triu(K, format="csr"), r)
            raise NotConverged(f"{MAX_ITERATIONS} iterations", MAX_ITERATIONS)

        path = in_load_steps(step, basis.zeros(), problem.load_steps)
        pardiso.free_memory(everything=True)
        return path

    def displacements(self, u: np.ndarray) -> np.ndarray:
        return u[self.node_dofs]


if __name__ == "__main__":
    run(Hemisphere, ScikitFem)
