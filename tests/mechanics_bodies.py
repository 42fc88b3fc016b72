"""Simple bodies for the tests of the mechanics, and where to look on them."""

import gmsh
import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.shapes import QUADRATIC_TETRAHEDRON, box
from mammosim.meshing.shapes import ball_part as sphere_part
from mammosim.meshing.tetrahedra import gmsh_session

__all__ = ["FAT", "HANGING", "LIGHT", "box", "cylinder", "nearest", "shell_octant", "sphere_part"]

# Light enough that a block, 50 mm tall, stretches by a tenth and does not buckle under reversed gravity.
FAT = Tissue(1.0, 0.45, 0.4)
LIGHT = Body({Label.ADIPOSE: FAT})
HANGING = np.array([0.0, 0.0, 1.0])


def shell_octant(inner, outer, edge):
    """x, y, z > 0 of a thick shell about the origin; its inside is the boundary `cavity`."""

    def draw(occ):
        ball, hole = (occ.addSphere(0, 0, 0, r, angle1=0, angle3=np.pi / 2) for r in (outer, inner))
        occ.cut([(3, ball)], [(3, hole)])

    mesh = _drawn(draw, edge)
    faces = mesh.boundaries["skin"]
    radii = np.linalg.norm(mesh.points[faces], axis=2)
    cavity = np.all(np.abs(radii - inner) < 1e-6 * inner, axis=1)
    return TetMesh(mesh.points, mesh.cells, mesh.tissue, {"cavity": faces[cavity], "skin": faces[~cavity]})


def cylinder(radius, length, edge):
    """About the z axis, 0 < z < length; all of its outside is `skin`."""
    return _drawn(lambda occ: occ.addCylinder(0, 0, 0, 0, 0, length, radius), edge)


def _drawn(draw, edge):
    """Curved quadratic tetrahedra of what draw(occ) adds."""
    with gmsh_session():
        gmsh.option.setNumber("Mesh.MeshSizeMin", edge)
        gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        cells = gmsh.model.mesh.getElementsByType(QUADRATIC_TETRAHEDRON)[1].reshape(-1, 10)
    cells = cells[
        :, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
    ]  # gmsh has the last two mid-edge nodes the other way round
    used, cells = np.unique(cells, return_inverse=True)
    points = coordinates.reshape(-1, 3)[np.argsort(tags)][np.searchsorted(np.sort(tags), used)]
    cells = cells.reshape(-1, 10)
    return TetMesh(points, cells, np.full(len(cells), int(Label.ADIPOSE)), {"skin": boundary_faces(cells)})


def nearest(mesh, point):
    """The node nearest to a point (3,)."""
    return int(np.argmin(np.linalg.norm(mesh.points - point, axis=1)))


def octant_fine_at_the_pole(radius, edge, *, reach, finest):
    """x, y, z > 0 of a ball about the origin, with elements `finest` within `reach` of (0, radius, 0)."""

    def draw(occ):
        occ.addSphere(0, 0, 0, radius, angle1=0, angle2=np.pi / 2, angle3=np.pi / 2)
        field = gmsh.model.mesh.field
        near = field.add("Ball")
        for name, value in {"Radius": reach, "Thickness": 0.7 * radius, "YCenter": radius}.items():
            field.setNumber(near, name, value)
        field.setNumber(near, "VIn", finest)
        field.setNumber(near, "VOut", edge)
        field.setAsBackgroundMesh(near)
        gmsh.option.setNumber("Mesh.MeshSizeMin", finest)

    return _drawn(draw, edge)
