"""The plates of a craniocaudal compression: where they stand, and how thick a breast is between them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.thickness import GIVEN
from mammosim.core.errors import MeshError
from mammosim.core.mesh import SUBTRIANGLES, TetMesh
from mammosim.core.settings import require_positive
from mammosim.io.compiled import njit
from mammosim.mechanics.effects import RoundedBox
from mammosim.mechanics.paddles import Plates

# Held points this far above and below the nipple are the ribs behind the breast, not a cut of the body.
LEVEL_MM = 40.0
# Skin this far above and below the nipple is the chest's; the plates pass it at this distance.
BREAST_MM, CLEARANCE_MM = 80.0, 1.0
# ASSUME: from the ribs to the edge of the plates: muscle, fat, skin and a little air.
GAP_MM = 20.0
UP, FORWARD = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])


@dataclass(frozen=True)
class PlateSize:
    """Of either plate, mm: width (x, centred on the nipple), depth (y), height (z), radius of its edges."""

    width: float
    depth: float
    height: float
    edge_radius: float

    def __post_init__(self) -> None:
        require_positive(self, "width", "depth", "height", "edge_radius")


@dataclass(frozen=True)
class PlacedPlates:
    """Plates before a breast; gap_mm: from the foremost rib behind it to their edge; origin: why there."""

    plates: Plates
    gap_mm: float
    origin: str = GIVEN


def craniocaudal_plates(
    mesh: TetMesh, nipple: np.ndarray, *, plate_mm: PlateSize, chest_gap_mm: float | None = None
) -> PlacedPlates:
    """Two horizontal plates in front of the chest wall, level with the breast between them.

    nipple (3,) mm, stress-free; chest_gap_mm: from the foremost rib behind the breast to the plates' chest
    edge, which also keeps clear of the chest's skin above and below the breast. None: GAP_MM, or more, so
    that the plates are clear of what is held at every distance from first contact on.
    Raises MeshError when no skin lies between them.
    """
    # ASSUME: the plates end in front of the chest's skin; the breast is not pulled onto them.
    # ASSUME: only one breast is between the plates; the other is kept out of their way.
    half_width = plate_mm.width / 2
    rib = _foremost_rib(mesh, nipple, half_width)
    skin = mesh.points[mesh.boundary_nodes("skin")]
    skin = skin[np.abs(skin[:, 0] - nipple[0]) < half_width]
    chest = skin[np.abs(skin[:, 2] - nipple[2]) > BREAST_MM, 1].min(initial=np.inf)
    wanted = rib - (GAP_MM if chest_gap_mm is None else chest_gap_mm)
    edge = min(wanted, chest - CLEARANCE_MM)
    plates = _before(edge, skin, nipple, plate_mm, rib)
    origin = f"chosen: {GAP_MM:g} mm" if chest_gap_mm is None else GIVEN
    if edge < wanted:
        origin += f", and {wanted - edge:.1f} mm clear of the chest's skin"
    if chest_gap_mm is None:
        held = mesh.points[mesh.boundary_nodes("posterior")]
        clear = edge
        while len(met := _met(held, plates, clear, plates.first_contact(skin))):
            clear = met[:, 1].min() - CLEARANCE_MM
            plates = _before(clear, skin, nipple, plate_mm, rib)
        if clear < edge:
            origin += f", and {edge - clear:.1f} mm clear of what is held at the chest"
            edge = clear
    return PlacedPlates(plates, float(rib - edge), origin)


def _foremost_rib(mesh: TetMesh, nipple: np.ndarray, half_width: float) -> float:
    """Its y in mm. Raises MeshError where no rib is behind a nipple (3,)."""
    behind = mesh.points[mesh.boundary_nodes("posterior")]
    near = (np.abs(behind[:, 0] - nipple[0]) < half_width) & (np.abs(behind[:, 2] - nipple[2]) < LEVEL_MM)
    if not near.any():
        raise MeshError(f"no chest wall within {half_width:g} mm of the nipple's x = {nipple[0]:.0f} mm")
    return float(behind[near, 1].min())


def _before(edge: float, skin: np.ndarray, nipple: np.ndarray, plate_mm: PlateSize, rib: float) -> Plates:
    """Plates that end at y = edge, level with the skin (n, 3) before it; rib: y of the foremost one, mm."""
    between = skin[skin[:, 1] < edge]
    if len(between) == 0:
        raise MeshError(
            f"no skin lies before the plates' chest edge at y = {edge:.0f} mm; the breast reaches to "
            f"{skin[:, 1].min():.0f} mm: reduce chest_gap_mm = {rib - edge:g}"
        )
    level = (between[:, 2].min() + between[:, 2].max()) / 2
    half = np.array([plate_mm.depth, plate_mm.width, plate_mm.height]) / 2
    centre = np.array([nipple[0], edge - half[0], level])
    axes = np.column_stack([FORWARD, np.cross(UP, FORWARD), UP])
    return Plates(centre, axes, half, plate_mm.edge_radius)


def _met(held: np.ndarray, plates: Plates, edge: float, contact_mm: float) -> np.ndarray:
    """Those of points (n, 3) that a plate passes at less than CLEARANCE_MM as it closes from contact_mm."""
    y = (held - plates.centre) @ plates.axes
    height, thick = np.abs(y[:, 2]), plates.half_sizes[2]
    nearest = np.clip(height, thick, contact_mm / 2 + thick)  # where the middle of the plate is then
    y[:, 2] = height - nearest
    box = RoundedBox(np.zeros(3), np.eye(3), plates.half_sizes, plates.edge_radius_mm)
    found: np.ndarray = held[(box.distance(y) < CLEARANCE_MM) & (held[:, 1] < edge + CLEARANCE_MM)]
    return found


def plate_facts(
    plates: Plates, thickness_mm: float, *, room_mm: tuple[float, float] = (0.0, 0.0)
) -> dict[str, float]:
    """Chest edge, side limits and inner faces of plates this far apart, mm.

    room_mm: how far paddle and support are beyond flat ones over the breast at most (Plates.room); so high
    is paddle_z_mm, and so low support_z_mm.
    """
    above, below = room_mm
    x, _, z = plates.centre
    return {
        "thickness_mm": thickness_mm,
        "chest_y_mm": float(plates.centre[1] + plates.half_sizes[0]),
        "low_x_mm": float(x - plates.half_sizes[1]),
        "high_x_mm": float(x + plates.half_sizes[1]),
        "support_z_mm": float(z - thickness_mm / 2 - max(0.0, below)),
        "paddle_z_mm": float(z - thickness_mm / 2 + max(thickness_mm, thickness_mm + above)),
        "depth_mm": float(2 * plates.half_sizes[0]),
        "height_mm": float(2 * plates.half_sizes[2]),
    }


COLUMNS = ["outward_mm", "across_mm", "thickness_mm"]


def thickness_map(mesh: TetMesh, plates: Plates, *, pixel_mm: float = 2.0) -> pd.DataFrame:
    """COLUMNS of the places under the paddle where there is tissue, a pixel apart.

    mesh: in its pressed shape. outward_mm: from the plates' chest edge; across_mm: from their middle;
    thickness_mm: from the lowest to the highest point of the body there, along the normal of the support.
    Raises MeshError when no tissue is there.
    """
    half, shift = plates.half_sizes, np.array([plates.half_sizes[0], 0.0, 0.0])
    counts = np.rint(2 * half[:2] / pixel_mm).astype(int)
    outward = (np.arange(counts[0]) + 0.5) * pixel_mm
    across = (np.arange(counts[1]) + 0.5 - counts[1] / 2) * pixel_mm
    places = (mesh.points - plates.centre) @ plates.axes + shift
    faces = np.vstack(list(mesh.boundaries.values()))[:, SUBTRIANGLES].reshape(-1, 3)
    low, high = _extent(places[faces], outward, across)
    found = np.nonzero(high > low)
    if len(found[0]) == 0:
        raise MeshError("no tissue lies between the plates; move their centre, or enlarge them")
    return pd.DataFrame(
        dict(zip(COLUMNS, (outward[found[0]], across[found[1]], high[found] - low[found]), strict=True))
    )


@njit(cache=True)
def _extent(triangles: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and greatest third coordinate (n_u, n_v) of triangles (n, 3, 3) over the places u, v."""
    low, high = np.full((len(u), len(v)), np.inf), np.full((len(u), len(v)), -np.inf)
    for t in range(len(triangles)):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        if area == 0.0:
            continue
        i0, i1 = np.searchsorted(u, min(p[0], q[0], r[0])), np.searchsorted(u, max(p[0], q[0], r[0]))
        j0, j1 = np.searchsorted(v, min(p[1], q[1], r[1])), np.searchsorted(v, max(p[1], q[1], r[1]))
        for i in range(i0, i1):
            for j in range(j0, j1):
                a = ((q[0] - u[i]) * (r[1] - v[j]) - (q[1] - v[j]) * (r[0] - u[i])) / area
                b = ((r[0] - u[i]) * (p[1] - v[j]) - (r[1] - v[j]) * (p[0] - u[i])) / area
                if a >= 0 and b >= 0 and a + b <= 1:
                    w = a * p[2] + b * q[2] + (1 - a - b) * r[2]
                    low[i, j], high[i, j] = min(low[i, j], w), max(high[i, j], w)
    return low, high
