"""Splitting, collapsing and flipping the edges of a closed triangle net, in place."""

from typing import NamedTuple

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.io.compiled import njit
from mammosim.meshing.lattice import dot

SHORT, LONG = 4 / 5, 4 / 3
# A triangle may turn by at most acos(0.5) = 60 degrees in one step, and a new edge may not fold sharper.
LEAST_COSINE = 0.5
MOST_NEIGHBOURS = 40


class Net(NamedTuple):
    """A closed triangle surface with room to grow; a, b, c, d are vertex numbers, s, t triangle numbers.

    P (n, 3): vertices in mm. h (n,): edge length wanted at each, mm. T (m, 3): vertices of each triangle,
    counter-clockwise from outside, -1 when it has been removed. around (n, MOST_NEIGHBOURS): the triangles
    around each vertex, of which the first n_around (n,) count.
    """

    P: np.ndarray
    h: np.ndarray
    T: np.ndarray
    around: np.ndarray
    n_around: np.ndarray


def resized(points: np.ndarray, triangles: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles with edges split, collapsed and flipped towards the vertex sizes h (n,).

    Raises MeshError when more than MOST_NEIGHBOURS triangles meet at a vertex.
    """
    if (most := np.bincount(triangles.ravel()).max()) > MOST_NEIGHBOURS:
        raise MeshError(
            f"{most} triangles meet at a vertex, at most {MOST_NEIGHBOURS} may; divide them first"
        )
    spare = len(points) + 1000
    n, m = len(points), len(triangles)
    net = Net(
        P=np.concatenate([points, np.zeros((spare, 3))]),
        h=np.concatenate([h, np.zeros(spare)]),
        T=np.concatenate([triangles, np.full((2 * spare, 3), -1)]),
        around=np.full((n + spare, MOST_NEIGHBOURS + 2), -1),
        n_around=np.zeros(n + spare, dtype=np.int64),
    )
    _register(net, m)
    m = _split_long(net, n, m)
    _collapse_short(net, m)
    _flip_bad(net, m)
    used, T = np.unique(net.T[net.T[:, 0] >= 0], return_inverse=True)
    return net.P[used], T.reshape(-1, 3)


@njit(cache=True)
def _register(net: Net, m: int) -> None:
    for t in range(m):
        for a in net.T[t]:
            _add(net, a, t)


@njit(cache=True)
def _add(net: Net, a: int, t: int) -> None:
    net.around[a, net.n_around[a]] = t
    net.n_around[a] += 1


@njit(cache=True)
def _remove(net: Net, a: int, t: int) -> None:
    last = net.n_around[a] - 1
    _exchange(net.around[a], t, net.around[a, last])
    net.n_around[a] = last


@njit(cache=True)
def _exchange(row: np.ndarray, old: int, new: int) -> None:
    for k in range(len(row)):
        if row[k] == old:
            row[k] = new
            return


@njit(cache=True)
def _triangle(net: Net, a: int, b: int) -> int:
    """The triangle with the directed edge a -> b, or -1."""
    for k in range(net.n_around[a]):
        t = net.around[a, k]
        for e in range(3):
            if net.T[t, e] == a and net.T[t, (e + 1) % 3] == b:
                return t
    return -1


@njit(cache=True)
def _third(net: Net, t: int, a: int, b: int) -> int:
    return net.T[t, 0] + net.T[t, 1] + net.T[t, 2] - a - b


@njit(cache=True)
def _length(net: Net, a: int, b: int) -> float:
    """Length of an edge over the length wanted there."""
    return np.sqrt(np.sum((net.P[a] - net.P[b]) ** 2)) / ((net.h[a] + net.h[b]) / 2)


@njit(cache=True)
def _normal(net: Net, a: int, b: int, c: int) -> np.ndarray:
    """Outward normal, twice as long as the triangle's area."""
    return np.cross(net.P[b] - net.P[a], net.P[c] - net.P[a])


@njit(cache=True)
def _agree(n1: np.ndarray, n2: np.ndarray) -> bool:
    return dot(n1, n2) > LEAST_COSINE * np.sqrt(dot(n1, n1) * dot(n2, n2))


@njit(cache=True)
def _shape(net: Net, a: int, b: int, c: int) -> float:
    """Area over the sum of squared edges: 0 for a flat triangle, largest for an equilateral one."""
    n, A, B, C = _normal(net, a, b, c), net.P[a], net.P[b], net.P[c]
    return np.sqrt(dot(n, n)) / np.sum((A - B) ** 2 + (B - C) ** 2 + (C - A) ** 2)


@njit(cache=True)
def _split_long(net: Net, n: int, m: int) -> int:
    """Put a vertex into the middle of edges longer than LONG times the size wanted; the new m."""
    for t in range(m):
        for e in range(3):
            a, b = net.T[t, e], net.T[t, (e + 1) % 3]
            if a > b or n == len(net.P) or _length(net, a, b) <= LONG:
                continue
            s = _triangle(net, b, a)
            c, d = _third(net, t, a, b), _third(net, s, a, b)
            if max(net.n_around[c], net.n_around[d]) < MOST_NEIGHBOURS:
                _split(net, (a, b, c, d), (t, s, n, m))
                n, m = n + 1, m + 2
    return m


@njit(cache=True)
def _split(net: Net, corners: tuple[int, int, int, int], numbers: tuple[int, int, int, int]) -> None:
    """Triangles t = abc and s = bad become anc, nad and, as m and m + 1, nbc and bnd."""
    (a, b, c, d), (t, s, n, m) = corners, numbers
    net.P[n], net.h[n] = (net.P[a] + net.P[b]) / 2, (net.h[a] + net.h[b]) / 2
    _exchange(net.T[t], b, n)
    _exchange(net.T[s], b, n)
    net.T[m, 0], net.T[m, 1], net.T[m, 2] = n, b, c
    net.T[m + 1, 0], net.T[m + 1, 1], net.T[m + 1, 2] = b, n, d
    _exchange(net.around[b], t, m)
    _exchange(net.around[b], s, m + 1)
    _add(net, c, m)
    _add(net, d, m + 1)
    for new in (t, s, m, m + 1):
        _add(net, n, new)


@njit(cache=True)
def _collapse_short(net: Net, m: int) -> None:
    """Merge the ends of edges shorter than SHORT times the size wanted, into whichever end allows it."""
    for t in range(m):
        for e in range(3):
            a, b = net.T[t, e], net.T[t, (e + 1) % 3]
            if a >= b or _length(net, a, b) >= SHORT:
                continue
            if _may_collapse(net, a, b):
                _collapse(net, a, b)
            elif _may_collapse(net, b, a):
                _collapse(net, b, a)


@njit(cache=True)
def _may_collapse(net: Net, a: int, b: int) -> bool:
    """Whether b can merge into a: no hole, no fold, no triangle turned over, no edge that is too long."""
    c, d = _third(net, _triangle(net, a, b), a, b), _third(net, _triangle(net, b, a), a, b)
    if min(net.n_around[c], net.n_around[d]) <= 3 or net.n_around[a] + net.n_around[b] - 4 > MOST_NEIGHBOURS:
        return False
    for k in range(net.n_around[b]):
        t = net.around[b, k]
        e = 0 if net.T[t, 0] == b else 1 if net.T[t, 1] == b else 2
        v, w = net.T[t, (e + 1) % 3], net.T[t, (e + 2) % 3]
        if v == a:
            continue
        # Link condition: a and b share no neighbours but c and d.
        if v not in (c, d) and _triangle(net, a, v) >= 0:
            return False
        if _length(net, a, v) > LONG or (w != a and not _agree(_normal(net, b, v, w), _normal(net, a, v, w))):
            return False
    return True


@njit(cache=True)
def _collapse(net: Net, a: int, b: int) -> None:
    for k in range(net.n_around[b]):
        t = net.around[b, k]
        if a in net.T[t]:
            _remove(net, a, t)
            _remove(net, _third(net, t, a, b), t)
            net.T[t] = -1
        else:
            _exchange(net.T[t], b, a)
            _add(net, a, t)
    net.n_around[b] = 0


@njit(cache=True)
def _flip_bad(net: Net, m: int) -> None:
    """Turn the edge a-b between triangles abc, bad into c-d where the worse of the two becomes better."""
    for t in range(m):
        for e in range(3):
            a, b = net.T[t, e], net.T[t, (e + 1) % 3]
            if a >= b:
                continue
            s = _triangle(net, b, a)
            c, d = _third(net, t, a, b), _third(net, s, a, b)
            if _may_flip(net, (a, b, c, d)):
                net.T[t, 0], net.T[t, 1], net.T[t, 2] = a, d, c
                net.T[s, 0], net.T[s, 1], net.T[s, 2] = d, b, c
                _remove(net, b, t)
                _remove(net, a, s)
                _add(net, c, s)
                _add(net, d, t)


@njit(cache=True)
def _may_flip(net: Net, corners: tuple[int, int, int, int]) -> bool:
    a, b, c, d = corners
    if min(net.n_around[a], net.n_around[b]) <= 3 or max(net.n_around[c], net.n_around[d]) >= MOST_NEIGHBOURS:
        return False
    if _triangle(net, c, d) >= 0 or _triangle(net, d, c) >= 0:
        return False
    before = min(_shape(net, a, b, c), _shape(net, b, a, d))
    after = min(_shape(net, a, d, c), _shape(net, d, b, c))
    mean = _normal(net, a, b, c) + _normal(net, b, a, d)
    kept = _agree(_normal(net, a, d, c), mean) and _agree(_normal(net, d, b, c), mean)
    return kept and after > before * (1 + 1e-9)
