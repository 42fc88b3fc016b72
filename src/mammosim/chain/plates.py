"""Where the plates of a craniocaudal compression stand, for one breast of a stress-free body."""

from collections.abc import Mapping

import numpy as np

from mammosim.core.errors import MeshError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.paddles import Plates

# Held points this far above and below the nipple are the ribs behind the breast, not a cut of the body.
LEVEL_MM = 40.0
# Skin this far above and below the nipple is the chest's; the plates pass it at this distance.
BREAST_MM, CLEARANCE_MM = 80.0, 1.0
UP, FORWARD = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])


def craniocaudal_plates(
    mesh: TetMesh, nipple: np.ndarray, *, plate_mm: Mapping[str, float], chest_gap_mm: float
) -> Plates:
    """Two horizontal plates in front of the chest wall, level with the breast between them.

    nipple (3,) mm, stress-free; plate_mm: width (x, centred on it), depth (y), height (z), edge_radius.
    chest_gap_mm: from the foremost rib behind the breast to the plates' chest edge,
    which also keeps clear of the chest's skin above and below the breast.
    Raises MeshError when no skin lies between them.
    """
    # ASSUME: the plates end in front of the chest's skin; the breast is not pulled onto them.
    # ASSUME: only one breast is between the plates; the other is kept out of their way.
    half_width = plate_mm["width"] / 2
    behind = mesh.points[mesh.boundary_nodes("posterior")]
    near = (np.abs(behind[:, 0] - nipple[0]) < half_width) & (np.abs(behind[:, 2] - nipple[2]) < LEVEL_MM)
    if not near.any():
        raise MeshError(f"no chest wall within {half_width:g} mm of the nipple's x = {nipple[0]:.0f} mm")
    skin = mesh.points[mesh.boundary_nodes("skin")]
    skin = skin[np.abs(skin[:, 0] - nipple[0]) < half_width]
    chest = skin[np.abs(skin[:, 2] - nipple[2]) > BREAST_MM, 1].min(initial=np.inf)
    edge = min(behind[near, 1].min() - chest_gap_mm, chest - CLEARANCE_MM)
    between = skin[skin[:, 1] < edge]
    if len(between) == 0:
        raise MeshError(
            f"no skin lies before the plates' chest edge at y = {edge:.0f} mm; the breast reaches to "
            f"{skin[:, 1].min():.0f} mm: reduce chest_gap_mm = {chest_gap_mm:g}"
        )
    level = (between[:, 2].min() + between[:, 2].max()) / 2
    half = np.array([plate_mm["depth"], plate_mm["width"], plate_mm["height"]]) / 2
    centre = np.array([nipple[0], edge - half[0], level])
    axes = np.column_stack([FORWARD, np.cross(UP, FORWARD), UP])
    return Plates(centre, axes, half, plate_mm["edge_radius"])


def plate_facts(plates: Plates, thickness_mm: float, *, widest_mm: float = 0.0) -> dict[str, float]:
    """Chest edge, side limits and inner faces of plates this far apart, mm.

    widest_mm: the largest distance of their faces where a paddle that yields is over the breast; paddle_z_mm
    is as high as that.
    """
    x, _, z = plates.centre
    return {
        "thickness_mm": thickness_mm,
        "chest_y_mm": float(plates.centre[1] + plates.half_sizes[0]),
        "low_x_mm": float(x - plates.half_sizes[1]),
        "high_x_mm": float(x + plates.half_sizes[1]),
        "support_z_mm": float(z - thickness_mm / 2),
        "paddle_z_mm": float(z - thickness_mm / 2 + max(thickness_mm, widest_mm)),
        "depth_mm": float(2 * plates.half_sizes[0]),
        "height_mm": float(2 * plates.half_sizes[2]),
    }
