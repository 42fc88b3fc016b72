"""Pairs that no modulus can explain: sides swapped, rigid motion left in, another woman."""

import numpy as np
from scipy.spatial.transform import Rotation

from mammosim.core.errors import IdentificationError
from mammosim.mechanics.reference import cell_quadrature
from mammosim.study.identification.fit import Fit
from mammosim.study.identification.pair import Pair

# Chest markers move with their skin by up to 2 mm between positions; a registration that failed leaves more.
LARGEST_SHIFT_MM, LARGEST_TURN_DEG = 4.0, 3.0
# What is left of the skin after a good fit is a third of a voxel or so, of the markers about their clicks.
LARGEST_SKIN_MM, LARGEST_MARKER_MM = 2.0, 3.0
# Soft tissue keeps its volume; where the body was cut out, some of it differs.
LARGEST_VOLUME_CHANGE = 0.1


def require_one_body(pair: Pair, *, middle_mm: float = 0.0) -> None:
    """Raises IdentificationError when fiducials say that the positions do not belong together as given."""
    names = pair.shared
    before = np.array([pair.start.fiducials.point(name)[0] for name in names]) - middle_mm
    after = pair.goals[:, 0] - middle_mm
    crossed = [name for name, one, other in zip(names, before, after) if one * other < 0]
    if 2 * len(crossed) > len(names):
        raise IdentificationError(
            f"{len(crossed)} of {len(names)} breast markers ({', '.join(crossed)}) change sides "
            "between the positions: left and right are swapped; check names and image orientation"
        )
    if not _marked_chest(pair):
        return  # each was cut out where its own shape says; that the rib cages match was found before
    one, other = _volumes_cm3(pair)
    if abs(other / one - 1) > LARGEST_VOLUME_CHANGE:
        raise IdentificationError(
            f"the soft tissue has {one:.0f} cm3 in one position and {other:.0f} cm3 in the other (at most "
            f"{100 * LARGEST_VOLUME_CHANGE:g} % apart): these are probably two women; check who was scanned"
        )
    shift, turn = chest_motion(pair)
    if shift > LARGEST_SHIFT_MM or turn > LARGEST_TURN_DEG:
        raise IdentificationError(
            f"by the chest markers, a rigid motion of {shift:.1f} mm and {turn:.1f} degrees was not "
            f"removed (at most {LARGEST_SHIFT_MM:g} mm, {LARGEST_TURN_DEG:g} degrees); register them again"
        )


def chest_motion(pair: Pair) -> tuple[float, float]:
    """Shift of their centre (mm) and turn (degrees) that bring the shared chest markers together best."""
    start, goal = pair.start.fiducials, pair.goal.fiducials
    kinds = dict(zip(start.names, start.kinds))
    shared = [name for name, kind in kinds.items() if kind == "chest" and name in goal.names]
    if len(shared) < 3:
        raise IdentificationError(
            f"the positions share {len(shared)} chest markers, a rigid motion shows in 3 or more; list them"
        )
    one, other = (np.array([side.point(name) for name in shared]) for side in (start, goal))
    turn, _ = Rotation.align_vectors(other - other.mean(axis=0), one - one.mean(axis=0))
    return float(np.linalg.norm(other.mean(axis=0) - one.mean(axis=0))), float(np.degrees(turn.magnitude()))


def require_explained(fit: Fit) -> None:
    """Raises IdentificationError when the best fit leaves more than measurement and model can."""
    left = fit.history[-1]
    if left.skin_rms_mm <= LARGEST_SKIN_MM and not left.marker_rms_mm > LARGEST_MARKER_MM:
        return
    raise IdentificationError(
        f"no moduli explain both positions: the best leave {left.skin_rms_mm:.1f} mm of the skin (at most "
        f"{LARGEST_SKIN_MM:g}) and {left.marker_rms_mm:.1f} mm of the markers (at most "
        f"{LARGEST_MARKER_MM:g}). The volumes agree: look for markers exchanged within a breast, a wrong "
        "segmentation, or what the model leaves out, such as ligaments"
    )


def _marked_chest(pair: Pair) -> bool:
    """Whether chest markers are in both positions."""
    return all(len(each.fiducials.of_kind("chest")) > 0 for each in (pair.start, pair.goal))


def _volumes_cm3(pair: Pair) -> tuple[float, float]:
    """Of the soft tissue in both positions."""
    meshes = (pair.start.mesh, pair.goal.mesh)
    one, other = (float(cell_quadrature(mesh.points, mesh.cells).volumes.sum()) for mesh in meshes)
    return one / 1e3, other / 1e3
