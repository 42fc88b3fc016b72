"""A mesh in any configuration as voxels, each of which knows where in its element it lies.

A quadratic tetrahedron with corners x0..x3 maps its local coordinates xi to
x(xi) = x0 + B xi + sum over edges (a, b) of 4 La Lb (x_ab - (x_a + x_b) / 2), B = (x1, x2, x3) - x0,
L = (1 - sum xi, xi). In the coordinates eta = B^-1 (x - x0) of the straight element, with the curvatures
d_ab = B^-1 (x_ab - (x_a + x_b) / 2) of its edges, this reads
eta(xi) = xi + (G + Q xi) xi, G_i = 4 d_0i, Q_ij = 2 (d_ij - d_0i - d_0j), d_ii = 0,
which Newton's method inverts from the start xi = eta, with the Jacobian 1 + G + 2 Q xi. In strongly curved
elements that start can lead out of the element although a solution lies in it; then others are tried.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.core.volume import Grid
from mammosim.io.compiled import njit, prange

# A voxel centre on a face shared by two elements must not fall between them; relative to the element.
ON_FACE = 1e-7
NEWTON_STEPS = 20
CONVERGED = 1e-6  # Newton step relative to the element; it doubles its digits, so that the error is 1e-12
FLAT = 1e-12  # volume over the cube of the edges
# With all |Q| below this, the start xi = eta found each of 10^6 points in random elements with J > 0.
STRONGLY_CURVED = 0.4
OTHER_STARTS = np.array(
    [[0.25, 0.25, 0.25], [0.7, 0.1, 0.1], [0.1, 0.7, 0.1], [0.1, 0.1, 0.7], [0.1, 0.1, 0.1]]
)
FAR = 4.0  # local coordinates beyond this do not come back
_EDGES = np.array(EDGES)


class _Elements(NamedTuple):
    """Inverse maps of the elements, in the grid's index coordinates (k, j, i).

    corner (n, 3): x0. inverse (n, 3, 3): B^-1. G (n, 3, 3), Q (n, 3, 3, 3): curvature, component first;
    curvature (n,): largest |Q|.
    low, high (n, 4): bounds of eta and, last, of 1 - sum eta. box (n, 2, 3): bounds in voxels.
    """

    corner: np.ndarray
    inverse: np.ndarray
    G: np.ndarray
    Q: np.ndarray
    curvature: np.ndarray
    low: np.ndarray
    high: np.ndarray
    box: np.ndarray


@dataclass(frozen=True)
class Raster:
    """Where the voxel centres of a grid lie in a mesh.

    cell: (nz, ny, nx) int32, the element around each voxel centre, -1 outside the mesh.
    weights: (n_inside, 10) float32, the element's shape functions at the centres inside, in array order.
    cells: (n_cell, 10) node numbers of the mesh.
    """

    cell: np.ndarray
    weights: np.ndarray
    cells: np.ndarray

    @property
    def inside(self) -> np.ndarray:
        """Which voxels (nz, ny, nx) have their centre inside the mesh."""
        return self.cell >= 0

    def carry(self, nodal: np.ndarray) -> np.ndarray:
        """Values (n_inside, k) of a nodal field (n_node, k) at the voxel centres inside.

        The nodes of another configuration of the same mesh say where the tissue of each voxel lies there.
        """
        values = np.ascontiguousarray(nodal, dtype=float).reshape(len(nodal), -1)
        carried = _carried(self.cell[self.inside], self.weights, self.cells, values)
        return carried.reshape(-1, *nodal.shape[1:])


def rasterise(mesh: TetMesh, grid: Grid) -> Raster:
    """Find the element and the shape functions of every voxel centre inside a mesh, curved or straight.

    Where elements overlap, the one with the lowest number has the voxel, however many threads there are.
    Raises MeshError when an element's corners lie in a plane.
    """
    elements = _elements(grid.indices(mesh.points)[mesh.cells])
    start, listed = _elements_of_slices(elements.box[:, :, 0], grid.shape[0])
    cell = np.full(grid.shape, -1, dtype=np.int32)
    _find(elements, start, listed, cell)
    voxel = np.flatnonzero(cell >= 0)
    return Raster(cell, _weights(elements, cell, voxel), mesh.cells)


def _elements(x: np.ndarray) -> _Elements:
    """From nodes x (n, 10, 3) in index coordinates."""
    B = np.moveaxis(x[:, 1:4] - x[:, :1], 1, 2)
    flat = np.flatnonzero(np.abs(np.linalg.det(B)) < FLAT * np.linalg.norm(B, axis=(1, 2)) ** 3)
    if len(flat):
        raise MeshError(f"{len(flat)} elements are flat, the first is number {flat[0]}; mend the mesh")
    inverse = np.linalg.inv(B)
    d = (x[:, 4:] - x[:, _EDGES].mean(axis=2)) @ np.moveaxis(inverse, 1, 2)
    low, high, box = _bounds(x[:, 0], B, d)
    G, Q = _curvature(d)
    return _Elements(x[:, 0].copy(), inverse, G, Q, np.abs(Q).max(axis=(1, 2, 3)), low, high, box)


def _curvature(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """G (n, 3, 3) and Q (n, 3, 3, 3) of edge curvatures d (n, 6, 3)."""
    d_ab = np.zeros((len(d), 4, 4, 3))
    for e, (a, b) in enumerate(EDGES):
        d_ab[:, a, b] = d_ab[:, b, a] = d[:, e]
    d_0i, d_ij = d_ab[:, 0, 1:], d_ab[:, 1:, 1:]
    G, Q = 4 * d_0i, 2 * (d_ij - d_0i[:, :, None] - d_0i[:, None])
    return np.ascontiguousarray(np.moveaxis(G, -1, 1)), np.ascontiguousarray(np.moveaxis(Q, -1, 1))


def _bounds(x0: np.ndarray, B: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bounds of eta and of the voxels, from the Bezier points: corners, and per edge its middle + 2 d."""
    eta = np.zeros((len(d), 10, 3))
    eta[:, 1:4] = np.eye(3)
    eta[:, 4:] = eta[:, _EDGES].mean(axis=2) + 2 * d
    L = np.concatenate([eta, 1 - eta.sum(axis=2, keepdims=True)], axis=2)
    hull = x0[:, None] + eta @ np.moveaxis(B, 1, 2)
    box = np.stack([np.ceil(hull.min(axis=1) - ON_FACE), np.floor(hull.max(axis=1) + ON_FACE) + 1], axis=1)
    return L.min(axis=1) - ON_FACE, L.max(axis=1) + ON_FACE, box.astype(np.int64)


def _elements_of_slices(span: np.ndarray, n_slice: int) -> tuple[np.ndarray, np.ndarray]:
    """Elements that reach slice k, ascending: listed[start[k]:start[k + 1]]; span (n, 2) first and end."""
    first, end = np.clip(span[:, 0], 0, n_slice), np.clip(span[:, 1], 0, n_slice)
    count = np.maximum(end - first, 0)
    number = np.repeat(np.arange(len(span)), count)
    k = first[number] + np.arange(len(number)) - np.repeat(np.cumsum(count) - count, count)
    start = np.concatenate([[0], np.cumsum(np.bincount(k, minlength=n_slice))])
    return start, number[np.argsort(k, kind="stable")]


@njit(cache=True, parallel=True)
def _find(elements: _Elements, start: np.ndarray, listed: np.ndarray, cell: np.ndarray) -> None:
    for k in prange(cell.shape[0]):
        xi = np.empty(3)
        for n in range(start[k], start[k + 1]):
            c = listed[n]
            box = elements.box[c]
            for j in range(max(box[0, 1], 0), min(box[1, 1], cell.shape[1])):
                for i in range(max(box[0, 2], 0), min(box[1, 2], cell.shape[2])):
                    if cell[k, j, i] < 0 and _holds(elements, c, (k, j, i), xi):
                        cell[k, j, i] = c


@njit(cache=True, parallel=True)
def _weights(elements: _Elements, cell: np.ndarray, voxel: np.ndarray) -> np.ndarray:
    """Shape functions (n, 10) at the voxels (n,), flat array indices."""
    _, nj, ni = cell.shape
    weights = np.empty((len(voxel), 10), dtype=np.float32)
    for n in prange(len(voxel)):
        xi = np.empty(3)
        k, j, i = voxel[n] // (nj * ni), voxel[n] // ni % nj, voxel[n] % ni
        _holds(elements, cell[k, j, i], (k, j, i), xi)
        L = (1 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2])
        for a in range(4):
            weights[n, a] = L[a] * (2 * L[a] - 1)
        for e in range(6):
            weights[n, 4 + e] = 4 * L[_EDGES[e, 0]] * L[_EDGES[e, 1]]
    return weights


@njit(cache=True)
def _holds(elements: _Elements, c: int, voxel: tuple[int, int, int], xi: np.ndarray) -> bool:
    """Whether element c holds a voxel's centre; xi (3,) becomes its local coordinates."""
    A, x0 = elements.inverse[c], elements.corner[c]
    low, high = elements.low[c], elements.high[c]
    y0, y1, y2 = voxel[0] - x0[0], voxel[1] - x0[1], voxel[2] - x0[2]
    eta = (
        A[0, 0] * y0 + A[0, 1] * y1 + A[0, 2] * y2,
        A[1, 0] * y0 + A[1, 1] * y1 + A[1, 2] * y2,
        A[2, 0] * y0 + A[2, 1] * y1 + A[2, 2] * y2,
    )
    for d in range(3):
        if not low[d] <= eta[d] <= high[d]:
            return False
    if not low[3] <= 1 - eta[0] - eta[1] - eta[2] <= high[3]:
        return False
    xi[0], xi[1], xi[2] = eta
    if _invert(elements.G[c], elements.Q[c], eta, xi):
        return True
    if elements.curvature[c] > STRONGLY_CURVED:
        for start in OTHER_STARTS:
            xi[:] = start
            if _invert(elements.G[c], elements.Q[c], eta, xi):
                return True
    return False


@njit(cache=True)
def _invert(G: np.ndarray, Q: np.ndarray, eta: tuple[float, float, float], xi: np.ndarray) -> bool:
    """Solve xi + (G + Q xi) xi = eta from the start xi; whether it converged inside the element."""
    J = np.empty((3, 3))
    r = np.empty(3)
    for _ in range(NEWTON_STEPS):
        for d in range(3):
            r[d] = xi[d] - eta[d]
            for i in range(3):
                Q_xi = Q[d, i, 0] * xi[0] + Q[d, i, 1] * xi[1] + Q[d, i, 2] * xi[2]
                r[d] += (G[d, i] + Q_xi) * xi[i]
                J[d, i] = G[d, i] + 2 * Q_xi
            J[d, d] += 1
        step = _solved(J, r)
        xi[0], xi[1], xi[2] = xi[0] - step[0], xi[1] - step[1], xi[2] - step[2]
        if max(abs(step[0]), abs(step[1]), abs(step[2])) < CONVERGED:
            return min(xi[0], xi[1], xi[2], 1 - xi[0] - xi[1] - xi[2]) >= -ON_FACE
        if not max(abs(xi[0]), abs(xi[1]), abs(xi[2])) < FAR:
            return False
    return False


@njit(cache=True)
def _solved(J: np.ndarray, r: np.ndarray) -> tuple[float, float, float]:
    """J^-1 r by Cramer's rule."""
    c0 = J[1, 1] * J[2, 2] - J[1, 2] * J[2, 1]
    c1 = J[1, 2] * J[2, 0] - J[1, 0] * J[2, 2]
    c2 = J[1, 0] * J[2, 1] - J[1, 1] * J[2, 0]
    det = J[0, 0] * c0 + J[0, 1] * c1 + J[0, 2] * c2
    if det == 0:
        return np.inf, np.inf, np.inf
    x0 = (
        c0 * r[0]
        + (J[0, 2] * J[2, 1] - J[0, 1] * J[2, 2]) * r[1]
        + (J[0, 1] * J[1, 2] - J[0, 2] * J[1, 1]) * r[2]
    )
    x1 = (
        c1 * r[0]
        + (J[0, 0] * J[2, 2] - J[0, 2] * J[2, 0]) * r[1]
        + (J[0, 2] * J[1, 0] - J[0, 0] * J[1, 2]) * r[2]
    )
    x2 = (
        c2 * r[0]
        + (J[0, 1] * J[2, 0] - J[0, 0] * J[2, 1]) * r[1]
        + (J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]) * r[2]
    )
    return x0 / det, x1 / det, x2 / det


@njit(cache=True, parallel=True)
def _carried(cell: np.ndarray, weights: np.ndarray, cells: np.ndarray, nodal: np.ndarray) -> np.ndarray:
    carried = np.zeros((len(cell), nodal.shape[1]))
    for n in prange(len(cell)):
        for a in range(10):
            for d in range(nodal.shape[1]):
                carried[n, d] += weights[n, a] * nodal[cells[cell[n], a], d]
    return carried
