"""The problem solved by dolfinx: PETSc's Newton with line search, with MUMPS or with algebraic multigrid.

The preconditioner is the last word of the command line: mumps or gamg.
"""

import sys

import dolfinx.fem.petsc as assembling
import numpy as np
import ufl
from _adapter import Hemisphere, NotConverged, Path, in_load_steps, run
from dolfinx import cpp, fem, mesh
from mpi4py import MPI
from petsc4py import PETSc
from scipy.spatial import cKDTree

OPTIONS = {
    "mumps": {"ksp_type": "preonly", "pc_type": "cholesky", "pc_factor_mat_solver_type": "mumps"},
    "gamg": {
        "ksp_type": "cg",
        "ksp_max_it": 500,
        "ksp_norm_type": "unpreconditioned",
        "ksp_rtol": 1e-4,
        "pc_type": "gamg",
        "mg_levels_ksp_type": "chebyshev",
        "mg_levels_pc_type": "jacobi",
    },
}
NEWTON = {"snes_type": "newtonls", "snes_linesearch_type": "bt", "snes_max_it": 40, "snes_stol": 0.0}


class Dolfinx:
    def __init__(self, problem: Hemisphere) -> None:
        self.problem = problem
        geometry = ufl.Mesh(ufl.VectorElement("Lagrange", "tetrahedron", 2))
        order = cpp.io.perm_vtk(mesh.CellType.tetrahedron, 10)
        cells = np.ascontiguousarray(problem.cells[:, order])
        self.mesh = mesh.create_mesh(MPI.COMM_SELF, cells, problem.points, geometry)

    def solve(self) -> Path:
        problem = self.problem
        self.space = fem.VectorFunctionSpace(self.mesh, ("Lagrange", 2))
        self.u, v = fem.Function(self.space), ufl.TestFunction(self.space)
        factor = fem.Constant(self.mesh, 0.0)
        mu, k = self._per_cell(problem.mu), self._per_cell(problem.k)
        F = ufl.Identity(3) + ufl.grad(self.u)
        J = ufl.det(F)
        W = mu / 2 * (J ** (-2 / 3) * ufl.inner(F, F) - 3) + k / 2 * (J - 1) ** 2
        dx = ufl.dx(metadata={"quadrature_degree": 2})
        residual = ufl.derivative((W - factor * problem.weight * self.u[2]) * dx, self.u, v)
        held = fem.locate_dofs_geometrical(self.space, lambda x: np.abs(x[2]) < 1e-9)
        bc = fem.dirichletbc(np.zeros(3), held, self.space)
        snes = self._newton(residual, bc)
        x = self.u.vector.copy()  # the line search writes to u while it still needs x

        def step(values: np.ndarray, target: float) -> tuple[np.ndarray, int]:
            factor.value = target
            x.array[:] = values
            snes.solve(None, x)
            if snes.getConvergedReason() <= 0:
                raise NotConverged(f"SNES reason {snes.getConvergedReason()}", snes.getIterationNumber())
            return x.array.copy(), snes.getIterationNumber()

        return in_load_steps(step, np.zeros(len(self.u.x.array)), problem.load_steps)

    def _per_cell(self, values: np.ndarray) -> fem.Function:
        found = fem.Function(fem.FunctionSpace(self.mesh, ("DG", 0)))
        found.x.array[:] = values[self.mesh.topology.original_cell_index]
        return found

    def _newton(self, residual: ufl.Form, bc: fem.DirichletBCMetaClass) -> PETSc.SNES:
        L, a = fem.form(residual), fem.form(ufl.derivative(residual, self.u))
        A, b = assembling.create_matrix(a), assembling.create_vector(L)

        def function(snes: PETSc.SNES, x: PETSc.Vec, f: PETSc.Vec) -> None:
            x.copy(self.u.vector)
            with f.localForm() as local:
                local.set(0.0)
            assembling.assemble_vector(f, L)
            assembling.set_bc(f, [bc], x, -1.0)

        def jacobian(snes: PETSc.SNES, x: PETSc.Vec, K: PETSc.Mat, P: PETSc.Mat) -> None:
            P.zeroEntries()
            assembling.assemble_matrix(P, a, [bc])
            P.assemble()

        A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        A.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        A.setNearNullSpace(self._rigid_motions())
        snes = PETSc.SNES().create(MPI.COMM_SELF)
        snes.setFunction(function, b)
        snes.setJacobian(jacobian, A)
        options = PETSc.Options()
        for name, value in {**NEWTON, **OPTIONS[sys.argv[5]], "snes_rtol": self.problem.tolerance}.items():
            options[name] = value
        snes.setFromOptions()
        return snes

    def _rigid_motions(self) -> PETSc.NullSpace:
        x, y, z = self.space.tabulate_dof_coordinates().T
        one, zero = np.ones_like(x), np.zeros_like(x)
        motions = [(one, zero, zero), (zero, one, zero), (zero, zero, one)]
        motions += [(-y, x, zero), (zero, -z, y), (z, zero, -x)]
        basis, _ = np.linalg.qr(np.column_stack([np.column_stack(motion).ravel() for motion in motions]))
        return PETSc.NullSpace().create(vectors=[PETSc.Vec().createWithArray(v.copy()) for v in basis.T])

    def displacements(self, u: np.ndarray) -> np.ndarray:
        _, dof = cKDTree(self.space.tabulate_dof_coordinates()).query(self.problem.points)
        return u.reshape(-1, 3)[dof]


if __name__ == "__main__":
    run(Hemisphere, Dolfinx)
