"""The truth's own body: its mesh, its equilibrium under gravity, and its rigid motion into the scanner."""

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.positions import gravity_direction
from mammosim.core.rigid import RigidTransform
from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.constitution import Constitution
from mammosim.digital.shape import skin_layers_mm
from mammosim.mechanics.equilibrium import Equilibrium, Settings
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.lattice import POINT_MM, on_lattice
from mammosim.meshing.surface import Surface, surface_of_field
from mammosim.meshing.tetrahedra import mesh_surface

FIELD_MM = 2.5  # spacing at which the stress-free shape is sampled for its surface
BLEND_MM = 25.0  # over which the element size grows from the breasts to the chest
LATTICE = 5  # points of a cell at which its tissue is asked: a lattice of this many along an edge


def truth_mesh(anatomy: Anatomy, *, breast_mm: float, chest_mm: float) -> TetMesh:
    """The stress-free soft tissue in the body frame, with tissues and the boundaries `skin` and `posterior`.

    Elements have about breast_mm in the breasts, growing to chest_mm away from them. Last bits of the fields
    do not change the mesh. Raises MeshError.
    """

    def size(points: np.ndarray) -> np.ndarray:
        distance = np.minimum(*(mound.distance(points) for mound in anatomy.mounds))
        return breast_mm + (chest_mm - breast_mm) * np.clip(distance / BLEND_MM, 0, 1)

    mesh = mesh_surface(_surface(anatomy), size=size)
    tissue = tissue_of_cells(anatomy, mesh)
    return TetMesh(mesh.points, mesh.cells, tissue, _boundaries(anatomy, mesh))


def load_truth(
    anatomy: Anatomy,
    mesh: TetMesh,
    gravity: np.ndarray,
    *,
    constitution: Constitution,
    settings: Settings | None = None,
) -> Equilibrium:
    """The body under gravity (3,), a unit vector in the body frame.

    Raises MechanicsError for an ill-posed problem, EquilibriumError when no verified equilibrium was reached.
    """
    return constitution.body(anatomy, mesh).load(mesh, gravity, settings=settings)


def tissue_of_cells(anatomy: Anatomy, mesh: TetMesh) -> np.ndarray:
    """Label (n_cell,) uint8 that most points of a cell have; skin is a membrane, its volume counts as fat."""
    barycentric = _lattice(LATTICE)
    corners = mesh.points[mesh.cells[:, :4]]
    points = np.einsum("qa,cai->cqi", barycentric, corners)
    labels = anatomy.labels_at(points.reshape(-1, 3)).reshape(points.shape[:2])
    solids = (Label.ADIPOSE, Label.GLANDULAR, Label.MUSCLE)
    labels[labels == Label.THORAX] = Label.MUSCLE
    labels[~np.isin(labels, solids)] = Label.ADIPOSE
    count = np.stack([(labels == solid).sum(axis=1) for solid in solids])
    return np.array(solids, np.uint8)[count.argmax(axis=0)]


def _surface(anatomy: Anatomy) -> Surface:
    chest = anatomy.patient.chest
    front = min(mound.nipple[1] for mound in anatomy.mounds)
    torso = chest.semi_axis_x_mm + skin_layers_mm(anatomy.patient)
    half_width = max(torso, *(abs(mound.centre[0]) + mound.radii[0] for mound in anatomy.mounds))
    high = np.array([half_width, chest.region_back_mm, chest.region_half_height_mm]) + 2 * FIELD_MM
    low = np.array([-high[0], front - 2 * FIELD_MM, -high[2]])
    grid = grid_around(on_lattice(low, POINT_MM), on_lattice(high, POINT_MM), FIELD_MM)
    return surface_of_field(anatomy.soft_tissue_field(grid.centres()).reshape(grid.shape), grid)


def _boundaries(anatomy: Anatomy, mesh: TetMesh) -> dict[str, np.ndarray]:
    """Outer faces: `skin` where the skin is nearer than the region's other limits, else `posterior`.

    Distances are compared to POINT_MM, so that last bits do not decide between equal ones.
    """
    outer = boundary_faces(mesh.cells)
    centres = mesh.points[outer[:, :3]].mean(axis=1)
    to_skin, to_rib, to_cut = (
        on_lattice(np.abs(field(centres)), POINT_MM)
        for field in (anatomy.outer_field, anatomy.rib_distance, anatomy.region_field)
    )
    skin = to_skin < np.minimum(to_rib, to_cut)
    return {"skin": outer[skin], "posterior": outer[~skin]}


def _lattice(n: int) -> np.ndarray:
    """Barycentric coordinates (m, 4) of a regular lattice inside a tetrahedron, n points along an edge."""
    steps = np.stack(np.meshgrid(*[np.arange(n)] * 4, indexing="ij"), axis=-1).reshape(-1, 4)
    steps = steps[steps.sum(axis=1) == n - 1]
    return (steps + 0.5) / (n + 1)


def motion(
    position: str, *, largest_deg: float, largest_mm: float, stream: tuple[str | int, ...]
) -> RigidTransform:
    """The motion from the body frame into the scanner frame of a position, drawn from its named stream.

    The rotation, by half to all of largest_deg, has any axis through the origin; the shift is half to all of
    largest_mm.
    """
    # ASSUME: between positions the rib cage moves rigidly, by a drawn angle and shift; nobody breathes.
    rng = generator(*stream, "motion", position)
    axis, shift = rng.normal(size=(2, 3))
    angle = rng.uniform(0.5, 1) * np.radians(largest_deg)
    length = rng.uniform(0.5, 1) * largest_mm
    R = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    return RigidTransform(R, length * shift / np.linalg.norm(shift))


def gravity_in_body(position: str, moved: RigidTransform) -> np.ndarray:
    """g_body = R^T g_scanner (3,): gravity is known in the scanner, the body lies turned in it."""
    return moved.R.T @ gravity_direction(position)
