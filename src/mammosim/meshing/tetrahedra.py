"""Quadratic tetrahedra inside a closed surface, by gmsh."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import gmsh
import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.meshing.boundary import topology
from mammosim.meshing.lattice import NODE_MM, POINT_MM, on_lattice
from mammosim.meshing.remesh import Size, of_volume, remeshed
from mammosim.meshing.surface import Surface

log = logging.getLogger(__name__)

LINEAR_TRIANGLE, LINEAR_TETRAHEDRON = 2, 4  # gmsh element types
ATTEMPTS = 3
FINER = 0.8
# gmsh bounds the circumradius: its edges inside come out about a quarter longer than the size it is given.
INSIDE = 0.8
# What a mesh depends on, named although most are defaults, since another release may have other defaults.
OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Mesh.MaxNumThreads1D": 1,
    "Mesh.MaxNumThreads2D": 1,
    "Mesh.MaxNumThreads3D": 1,
    "Mesh.RandomSeed": 1,
    "Mesh.RandomFactor": 1e-9,
    "Mesh.RandomFactor3D": 1e-12,
    "Mesh.Algorithm": 6,  # frontal Delaunay
    "Mesh.Algorithm3D": 1,  # Delaunay; HXT (10) depends on the number of threads
    "Mesh.Optimize": 1,
    "Mesh.OptimizeThreshold": 0.3,
}


def mesh_surface(
    surface: Surface, *, size: float | Size, volume_mm3: float | None = None, most_mm: float = np.inf
) -> TetMesh:
    """Straight-edged quadratic tetrahedra, all ADIPOSE, without named boundaries.

    size: edge length in mm, a number or a function of points (n, 3) that gives (n,). The surface is first
    given triangles of that size. Where they are too coarse for the shape, so that gmsh cannot fill them,
    the size is reduced to FINER times and tried again. volume_mm3: what they are to enclose, for which they
    move by at most most_mm along their normals. The same input gives the same mesh, on any processor:
    the points of the surface and the sizes are rounded to POINT_MM.
    Raises MeshError when the surface cannot be filled.
    """
    surface = Surface(on_lattice(surface.points, POINT_MM), surface.triangles)
    wanted = _rounded(size if callable(size) else _everywhere(size))
    for attempt in range(ATTEMPTS):
        try:
            scaled = _scaled(wanted, FINER**attempt)
            net = remeshed(surface, scaled)
            net = net if volume_mm3 is None else of_volume(net, volume_mm3, most_mm=most_mm)
            points, tetrahedra = _filled(net, _scaled(scaled, INSIDE))
        except MeshError as error:
            log.warning("attempt %d of %d at the surface: %s", attempt + 1, ATTEMPTS, error)
        else:
            points, cells = quadratic(points, tetrahedra)
            return TetMesh(points, cells, np.full(len(cells), Label.ADIPOSE, dtype=np.uint8))
    raise MeshError(
        f"gmsh could not fill the surface in {ATTEMPTS} attempts; "
        "smooth the labels more, or ask for a smaller element size"
    )


def _everywhere(size: float) -> Size:
    if not size > 0:
        raise MeshError(f"element size {size:g} mm must be positive")
    return lambda points: np.full(len(points), float(size))


def _rounded(size: Size) -> Size:
    return lambda points: on_lattice(size(points), POINT_MM)


def _scaled(size: Callable, factor: float) -> Size:
    return lambda points: factor * size(points)


def _filled(surface: Surface, size: Size) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and linear tetrahedra (m, 4) inside a surface whose triangles are kept."""
    with gmsh_session():
        gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z, lc: float(size(np.array([[x, y, z]]))[0]))
        gmsh.model.addDiscreteEntity(2, 1)
        gmsh.model.mesh.addNodes(2, 1, np.arange(1, len(surface.points) + 1), surface.points.ravel())
        gmsh.model.mesh.addElementsByType(1, LINEAR_TRIANGLE, [], surface.triangles.ravel() + 1)
        gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop([1])])
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.optimize("")
        gmsh.model.mesh.optimize("Netgen")
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(LINEAR_TETRAHEDRON)
    order = np.argsort(tags)
    points = on_lattice(coordinates.reshape(-1, 3)[order], NODE_MM)
    used, tetrahedra = np.unique(np.searchsorted(tags[order], corners), return_inverse=True)
    return points[used], tetrahedra.reshape(-1, 4)


@contextmanager
def gmsh_session() -> Iterator[None]:
    """A silent gmsh session of one thread, with the same random numbers, free of personal settings."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        yield
    except Exception as error:  # gmsh raises nothing more specific
        raise MeshError(f"gmsh: {error}") from error
    finally:
        gmsh.finalize()


def quadratic(points: np.ndarray, tetrahedra: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points with the middles of the edges appended, and cells (m, 10) in VTK order."""
    straight = topology(tetrahedra)
    cells = np.hstack([tetrahedra, len(points) + straight.t2e.T])
    return np.vstack([points, points[straight.edges.T].mean(axis=1)]), cells
