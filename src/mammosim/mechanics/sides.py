"""A body whose left and right halves have moduli of their own."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import CellTissues, Tissues
from mammosim.mechanics.body import Body, Skin
from mammosim.mechanics.mixture import cell_tissues
from mammosim.mechanics.soundness import faces_of

SIDES = ("left", "right")


def is_left(mesh: TetMesh, elements: np.ndarray, middle_mm: float) -> np.ndarray:
    """Which elements (n, m), cells or faces, lie to the left (x > middle_mm by the mean of their nodes)."""
    left: np.ndarray = mesh.points[elements, 0].mean(axis=1) > middle_mm
    return left


def sided_body(
    mesh: TetMesh, tissues: Mapping[str, Tissues], skins: Mapping[str, Skin], *, middle_mm: float
) -> Body:
    """The body of `mesh`, and of the same cells in any other shape, with tissues and skin per side.

    tissues, skins: of `left` and of `right`; the skins differ in nothing but modulus and thickness.
    middle_mm: x of the plane between the sides, in the frame of the mesh.
    Raises MechanicsError for a tissue of the mesh without parameters, or a mesh without skin.
    """
    left = is_left(mesh, mesh.cells, middle_mm)
    one, other = (cell_tissues(mesh, tissues[side]) for side in SIDES)
    names = ("youngs_modulus_kpa", "poisson_ratio", "density_g_cm3")
    both = CellTissues(*(np.where(left, getattr(one, name), getattr(other, name)) for name in names))
    return Body(both, (_sided_skin(mesh, skins, middle_mm),))


def _sided_skin(mesh: TetMesh, skins: Mapping[str, Skin], middle_mm: float) -> Skin:
    left = is_left(mesh, faces_of(mesh, skins["left"].boundary), middle_mm)
    per_face = {
        name: np.where(left, *(getattr(skins[side], name) for side in SIDES))
        for name in ("youngs_modulus_kpa", "thickness_mm")
    }
    return replace(skins["left"], **per_face)
