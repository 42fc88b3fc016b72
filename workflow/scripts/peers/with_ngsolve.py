"""The problem solved by NGSolve: its Newton for energies with line search, and its sparse Cholesky."""

import netgen.meshing as netgen
import ngsolve as ng
import numpy as np
from _adapter import Hemisphere, NotConverged, Path, in_load_steps, run

MAX_ITERATIONS = 30
# NGSolve measures the last correction in the norm of the energy; what it leaves is of second order.
CORRECTION = 1e-4
# The four points of degree 2, as the other programs have them (Keast 1986).
NEAR, FAR = 0.5854101966249685, 0.1381966011250105
POINTS = ng.IntegrationRule(
    [tuple(NEAR if i == j else FAR for j in range(3)) for i in range(4)], [1 / 24] * 4
)
FROM_VTK = [0, 1, 2, 3, 4, 6, 7, 5, 8, 9]
BUBBLE_AT_MIDDLE = -1 / 8  # of the function that NGSolve adds on an edge


class NGSolve:
    """corners: nodes that are vertices; middles (n_edge,): the node on each edge of NGSolve."""

    def __init__(self, problem: Hemisphere) -> None:
        self.problem = problem
        self.corners = np.unique(problem.cells[:, :4])
        raw = netgen.Mesh(dim=3)
        # Netgen takes all points up to the last corner for vertices, so corners come first.
        nodes = np.concatenate([self.corners, np.setdiff1d(problem.cells, self.corners)])
        ids = {node: raw.Add(netgen.MeshPoint(netgen.Pnt(*problem.points[node]))) for node in nodes}
        for domain, cells in enumerate(problem.same_material(), start=1):
            raw.SetMaterial(domain, f"domain_{domain}")
            for cell in problem.cells[cells][:, FROM_VTK]:
                raw.Add(netgen.Element3D(domain, [ids[node] for node in cell]))
        self.mesh = ng.Mesh(raw)
        self.ends = np.array([[v.nr for v in edge.vertices] for edge in self.mesh.edges])
        middle = problem.middle_nodes()
        self.middles = np.array([middle[a, b] for a, b in np.sort(self.corners[self.ends], axis=1)])
        self.held = np.isin(np.concatenate([self.corners, self.middles]), problem.held)

    def solve(self) -> Path:
        problem, mesh = self.problem, self.mesh
        space = ng.VectorH1(mesh, order=2)
        free = ng.BitArray(~np.tile(self.held, 3))
        u, shape = space.TrialFunction(), ng.GridFunction(space)
        factor = ng.Parameter(0.0)
        mu, k = (
            ng.CF([float(values[cells[0]]) for cells in problem.same_material()])
            for values in (problem.mu, problem.k)
        )
        F = ng.Id(3) + ng.Grad(u)
        J = ng.Det(F)
        W = mu / 2 * (J ** (-2 / 3) * ng.InnerProduct(F, F) - 3) + k / 2 * (J - 1) ** 2
        form = ng.BilinearForm(space, symmetric=True)
        rule = {ng.ET.TET: POINTS}
        form += ng.Variation((W - factor * problem.weight * u[2]).Compile() * ng.dx(intrules=rule))

        def step(values: np.ndarray, target: float) -> tuple[np.ndarray, int]:
            factor.Set(target)
            shape.vec.FV().NumPy()[:] = values
            failed, iterations = ng.solvers.NewtonMinimization(
                form,
                shape,
                freedofs=free,
                maxit=MAX_ITERATIONS,
                maxerr=CORRECTION,
                inverse="sparsecholesky",
                linesearch=True,
                printing=False,
            )
            found = shape.vec.FV().NumPy().copy()
            if failed or not np.isfinite(found).all():
                raise NotConverged(f"{iterations} iterations", iterations)
            return found, iterations

        return in_load_steps(step, np.zeros(space.ndof), problem.load_steps)

    def displacements(self, values: np.ndarray) -> np.ndarray:
        """(n_node, 3) of the coefficients: hierarchical, so an edge adds to the mean of its ends."""
        u = np.empty_like(self.problem.points)
        vertices, edges = np.split(values.reshape(3, -1).T, [len(self.corners)])
        u[self.corners] = vertices
        u[self.middles] = vertices[self.ends].mean(axis=1) + BUBBLE_AT_MIDDLE * edges
        return u


if __name__ == "__main__":
    run(Hemisphere, NGSolve)
