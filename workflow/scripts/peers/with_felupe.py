"""The problem solved by felupe: its Newton with its line search, and PARDISO for symmetric matrices."""

import felupe as fem
import numpy as np
from _adapter import Hemisphere, NotConverged, Path, in_load_steps, run
from pypardiso import PyPardisoSolver
from scipy.sparse import csr_matrix, triu

MAX_ITERATIONS = 30


class Pardiso:
    """LDL^T of the upper triangle; counts its calls."""

    def __init__(self) -> None:
        self.calls = 0
        self.solver = PyPardisoSolver(mtype=-2)

    def __call__(self, A: csr_matrix, b: np.ndarray) -> np.ndarray:
        self.calls += 1
        return self.solver.solve(triu(A, format="csr"), np.asarray(b).ravel())


class Felupe:
    def __init__(self, problem: Hemisphere) -> None:
        self.problem = problem

    def solve(self) -> Path:
        problem, pardiso = self.problem, Pardiso()
        field = self._field(problem.cells)
        solids = [self._solid(cells) for cells in problem.same_material()]
        weight = fem.SolidBodyForce(field)
        held = np.isin(np.arange(len(problem.points)), problem.held)
        dof0, dof1 = fem.dof.partition(field, {"held": fem.Boundary(field[0], mask=held)})

        def step(u: np.ndarray, factor: float) -> tuple[np.ndarray, int]:
            before = pardiso.calls
            field[0].values = u
            weight.update([0.0, 0.0, factor * problem.weight])
            try:
                found = fem.newtonraphson(
                    x0=field,
                    items=[*solids, weight],
                    dof0=dof0,
                    dof1=dof1,
                    solver=pardiso,
                    tol=problem.tolerance,
                    maxiter=MAX_ITERATIONS,
                    plugins=[fem.LinesearchPlugin()],
                    verbose=0,
                )
            except fem.NewtonConvergenceError as failure:
                raise NotConverged(str(failure), pardiso.calls - before) from None
            return found.x[0].values, pardiso.calls - before

        path = in_load_steps(step, np.zeros_like(problem.points), problem.load_steps)
        pardiso.solver.free_memory(everything=True)
        return path

    def displacements(self, u: np.ndarray) -> np.ndarray:
        return u

    def _field(self, cells: np.ndarray) -> fem.FieldContainer:
        mesh = fem.Mesh(self.problem.points, cells, cell_type="tetra10")
        return fem.FieldContainer([fem.Field(fem.RegionQuadraticTetra(mesh), dim=3)])

    def _solid(self, cells: np.ndarray) -> fem.SolidBody:
        """The body of the cells of one material; its points are those of the whole mesh."""
        law = fem.NeoHooke(mu=self.problem.mu[cells[0]], bulk=self.problem.k[cells[0]])
        return fem.SolidBody(law, self._field(self.problem.cells[cells]))


if __name__ == "__main__":
    run(Hemisphere, Felupe)
