"""Quadratic tetrahedra and triangles in the reference configuration: quadrature, soundness, strain of cells.

Shape functions and quadrature points are those of scikit-fem, whose order of the nodes is that of VTK. Cells
may be straight or curved: gradients are computed at every quadrature point, by compiled kernels, which are
faster than its mappings (decisions/mechanics_scikit_fem.md).
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from skfem.element import ElementH1, ElementTetP2, ElementTriP2
from skfem.quadrature import get_quadrature

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.io.compiled import njit, prange

TETRAHEDRON, TRIANGLE = ElementTetP2(), ElementTriP2()


def quadrature(element: ElementH1, degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric points L (n_point, n_vertex) and weights (n_point,), which sum to the element's volume."""
    xi, weights = get_quadrature(element.refdom, degree)
    return np.vstack([1 - xi.sum(axis=0), xi]).T.copy(), weights


# Four points with equal weights (Keast 1986), and six (Dunavant 1985).
TETRAHEDRON_POINTS, TETRAHEDRON_WEIGHTS = quadrature(TETRAHEDRON, 2)
TRIANGLE_POINTS, TRIANGLE_WEIGHTS = quadrature(TRIANGLE, 4)


def shape_functions(L: np.ndarray, element: ElementH1) -> np.ndarray:
    """N (n_point, n_node) at barycentric points L (n_point, n_vertex)."""
    return np.stack([element.lbasis(L.T[1:], a)[0] for a in range(len(element.doflocs))], axis=1)


def shape_gradients(L: np.ndarray, element: ElementH1) -> np.ndarray:
    """dN/dxi (n_point, n_node, n_vertex - 1), with xi_i = L_(i+1) and L_0 = 1 - sum xi."""
    return np.stack([element.lbasis(L.T[1:], a)[1].T for a in range(len(element.doflocs))], axis=1)


@dataclass(frozen=True)
class CellQuadrature:
    """gradients (n_cell, 4, 10, 3): dN/dX [1/mm]; volumes (n_cell, 4): reference volume of a point [mm3]."""

    gradients: np.ndarray
    volumes: np.ndarray


def smallest_jacobians(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The smallest det dX/dxi (n_cell,) of each whole cell, also between the quadrature points.

    The determinant is a cubic, so within its Bernstein coefficients: where none is below the smallest corner
    value, the answer is exact. Other cells are sampled on a lattice of eighths of their edges.
    """
    bernstein = _jacobians_at(points, cells, _CUBIC) @ _TO_BERNSTEIN.T
    corners: np.ndarray = bernstein[:, :4].min(axis=1)
    unsure = np.flatnonzero(bernstein.min(axis=1) < corners)
    corners[unsure] = _jacobians_at(points, cells[unsure], _EIGHTHS).min(axis=1)
    return corners


def _jacobians_at(points: np.ndarray, cells: np.ndarray, L: np.ndarray) -> np.ndarray:
    """det dX/dxi (n_cell, n_point) at barycentric points L (n_point, 4)."""
    dN = shape_gradients(L, TETRAHEDRON)
    a, b, c = (np.einsum("eai,qa->ieq", points[cells], dN[..., j], optimize=True) for j in range(3))
    det: np.ndarray = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return det


def _lattice(n: int) -> np.ndarray:
    """Barycentric coordinates that are multiples of 1/n (n_point, 4), the corners first."""
    L = np.array([L for L in product(range(n, -1, -1), repeat=4) if sum(L) == n])
    return L[np.argsort(L.max(axis=1) < n, kind="stable")] / n


def _bernstein(L: np.ndarray, lattice: np.ndarray) -> np.ndarray:
    """The cubic Bernstein polynomials 3!/(i! j! k! l!) L^(i, j, k, l), lattice (n_b, 4), L (n_point, 4)."""
    powers = np.rint(3 * lattice)
    weights = 6 / np.prod(np.where(powers > 1, powers * np.maximum(powers - 1, 1), 1.0), axis=1)
    B: np.ndarray = weights * np.prod(L[:, None, :] ** powers, axis=2)
    return B


_CUBIC, _EIGHTHS = _lattice(3), _lattice(8)
_TO_BERNSTEIN = np.linalg.inv(_bernstein(_CUBIC, _CUBIC))


def cell_quadrature(points: np.ndarray, cells: np.ndarray) -> CellQuadrature:
    """Four-point quadrature of quadratic tetrahedra with points (n_node, 3) and cells (n_cell, 10)."""
    dN = shape_gradients(TETRAHEDRON_POINTS, TETRAHEDRON)
    return CellQuadrature(*_gradients_and_volumes(points, cells, dN, TETRAHEDRON_WEIGHTS))


@njit(cache=True, parallel=True, error_model="numpy")
def _gradients_and_volumes(
    points: np.ndarray, cells: np.ndarray, dN: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """dN_a/dX = dN_a/dxi A^-1 and w det A with A = dX/dxi = sum_a X_a (x) dN_a/dxi, by cofactors."""
    n_cell, n_q = len(cells), len(weights)
    gradients, volumes = np.empty((n_cell, n_q, 10, 3)), np.empty((n_cell, n_q))
    for e in prange(n_cell):
        A, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            A[:] = 0.0
            for a in range(10):
                for i in range(3):
                    for j in range(3):
                        A[i, j] += points[cells[e, a], i] * dN[q, a, j]
            for i in range(3):
                k, m = (i + 1) % 3, (i + 2) % 3
                for j in range(3):
                    n, o = (j + 1) % 3, (j + 2) % 3
                    C[i, j] = A[k, n] * A[m, o] - A[k, o] * A[m, n]
            det = A[0, 0] * C[0, 0] + A[0, 1] * C[0, 1] + A[0, 2] * C[0, 2]
            volumes[e, q] = weights[q] * det
            for a in range(10):
                for k in range(3):
                    s = dN[q, a, 0] * C[k, 0] + dN[q, a, 1] * C[k, 1] + dN[q, a, 2] * C[k, 2]
                    gradients[e, q, a, k] = s / det
    return gradients, volumes


@dataclass(frozen=True)
class FaceQuadrature:
    """Quadratic triangles in space.

    gradients (n_face, 6, 6, 2): dN_a/ds [1/mm] along two orthonormal tangents of the reference face;
    areas (n_face, 6): reference area of each point [mm2].
    """

    gradients: np.ndarray
    areas: np.ndarray


def face_quadrature(points: np.ndarray, faces: np.ndarray) -> FaceQuadrature:
    """Six-point quadrature of quadratic triangles with points (n_node, 3) and faces (n_face, 6)."""
    dN = shape_gradients(TRIANGLE_POINTS, TRIANGLE)
    A = np.einsum("eai,qaj->eqij", points[faces], dN)  # dX/dxi (n_face, 6, 3, 2)
    t1 = A[..., 0] / np.linalg.norm(A[..., 0], axis=-1, keepdims=True)
    normal = np.cross(A[..., 0], A[..., 1])
    area = np.linalg.norm(normal, axis=-1)
    t2 = np.cross(normal / area[..., None], t1)
    B = np.einsum("eqit,eqij->eqtj", np.stack([t1, t2], axis=-1), A)  # ds/dxi, 2 x 2
    gradients = np.einsum("qaj,eqjk->eqak", dN, np.linalg.inv(B))
    return FaceQuadrature(np.ascontiguousarray(gradients), area * TRIANGLE_WEIGHTS)


FACE_SHAPES = shape_functions(TRIANGLE_POINTS, TRIANGLE)
CELL_SHAPES = shape_functions(TETRAHEDRON_POINTS, TETRAHEDRON)


# A cell flatter than this, relative to the cube of its longest edge, has lost all digits of its gradients.
SMALLEST_RELATIVE_VOLUME = 1e-6


def require_well_posed(mesh: TetMesh, held: np.ndarray | None) -> np.ndarray:
    """held (n_node, 3) bool, when the mesh can be solved; None where it has no boundary 'posterior'.

    Raises MechanicsError, naming cells or nodes and how many.
    """
    if held is None:
        names = ", ".join(sorted(mesh.boundaries)) or "none"
        raise MechanicsError(f"the mesh has no boundary 'posterior' (it has: {names}), so nothing is held")
    if not held.any():
        raise MechanicsError("the boundary 'posterior' is empty: nothing is held")
    _require_finite(mesh)
    _require_positive_cells(mesh)
    _require_attached(mesh, np.any(held, axis=1))
    return held


def faces_of(mesh: TetMesh, boundary: str) -> np.ndarray:
    """The faces (n_face, 6) of a named boundary. Raises MechanicsError when the mesh has none."""
    if boundary not in mesh.boundaries:
        names = ", ".join(sorted(mesh.boundaries)) or "none"
        raise MechanicsError(f"the mesh has no boundary {boundary!r}; it has: {names}")
    return mesh.boundaries[boundary]


def _require_finite(mesh: TetMesh) -> None:
    bad = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if len(bad):
        raise MechanicsError(f"{len(bad)} nodes have coordinates that are no numbers: {_listed(bad)}")


def _require_positive_cells(mesh: TetMesh) -> None:
    smallest = smallest_jacobians(mesh.points, mesh.cells)
    corners = mesh.points[mesh.cells[:, :4]]
    edges = corners[:, [0, 0, 0, 1, 1, 2]] - corners[:, [1, 2, 3, 2, 3, 3]]
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    bad = np.flatnonzero(smallest <= SMALLEST_RELATIVE_VOLUME * longest**3)
    if len(bad):
        raise MechanicsError(
            f"{len(bad)} cells are inverted or flat (det dX/dxi down to {smallest.min():.3g} mm3): "
            f"{_listed(bad)}; re-mesh, or move their mid-edge nodes to the middle"
        )


def _require_attached(mesh: TetMesh, held: np.ndarray) -> None:
    n_node = len(mesh.points)
    used = np.zeros(n_node, dtype=bool)
    used[mesh.cells] = True
    if not used.all():
        loose = np.flatnonzero(~used)
        raise MechanicsError(f"{len(loose)} nodes belong to no cell: {_listed(loose)}; remove them")
    first = np.repeat(mesh.cells[:, 0], 10)
    links = sparse.coo_matrix((np.ones(first.size), (first, mesh.cells.ravel())), (n_node, n_node))
    count, piece = connected_components(links, directed=False)
    floating = np.setdiff1d(np.arange(count), piece[held])
    if len(floating):
        cells = np.flatnonzero(np.isin(piece[mesh.cells[:, 0]], floating))
        raise MechanicsError(
            f"{len(floating)} pieces of the mesh ({len(cells)} cells: {_listed(cells)}) are not attached to "
            "'posterior'; remove them, or connect them"
        )


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(map(str, numbers[:5])) + (", ..." if len(numbers) > 5 else "")


@dataclass(frozen=True)
class CellStrain:
    """Averages over the reference volume of each cell.

    F (n_cell, 3, 3) = dx/dX; J (n_cell,): volume ratio of the cell; principal (n_cell, 3): ascending
    principal values of the Green-Lagrange strain E = (F^T F - 1) / 2; volume (n_cell,): reference, mm3.
    """

    F: np.ndarray
    J: np.ndarray
    principal: np.ndarray
    volume: np.ndarray

    @property
    def green_lagrange(self) -> np.ndarray:
        """E (n_cell, 3, 3) = (F^T F - 1) / 2."""
        E: np.ndarray = (np.swapaxes(self.F, 1, 2) @ self.F - np.eye(3)) / 2
        return E

    @property
    def logarithmic(self) -> np.ndarray:
        """Ascending principal values (n_cell, 3) of Hencky's strain ln U = ln(2 E + 1) / 2, U^2 = F^T F."""
        H: np.ndarray = np.log1p(2 * self.principal) / 2
        return H


def cell_strain(mesh: TetMesh, x: np.ndarray) -> CellStrain:
    """Strain of the cells of a mesh, whose points are the reference, in the loaded shape x (n_node, 3)."""
    quadrature = cell_quadrature(mesh.points, mesh.cells)
    F = np.einsum("eai,eqaj->eqij", x[mesh.cells], quadrature.gradients)
    volume = quadrature.volumes.sum(axis=1)
    weights = quadrature.volumes / volume[:, None]
    mean_F = np.einsum("eq,eqij->eij", weights, F)
    J = np.einsum("eq,eq->e", weights, np.linalg.det(F))
    E = (np.swapaxes(mean_F, 1, 2) @ mean_F - np.eye(3)) / 2
    return CellStrain(mean_F, J, np.linalg.eigvalsh(E), volume)
