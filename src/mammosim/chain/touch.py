"""Where skin touches a plate, and how hard: numbers that hardly depend on the stiffness of the contact."""

import numpy as np
import pandas as pd

from mammosim.core.units import MN_PER_N
from mammosim.mechanics.compression import Compression
from mammosim.mechanics.effects import RigidContact

# ASSUME: skin nearer to a plate than 0.1 mm, the penetration that the contact accepts, touches it.
NEAR_MM = 0.1


def touching_area(contact: RigidContact, x: np.ndarray) -> float:
    """Area in mm2 of the skin, in the loaded shape x (n_node, 3), that touches a plate."""
    _, distance = contact.at_points(x)
    return float(contact.rule.areas(x, contact.faces)[distance < NEAR_MM].sum())


def face_pressures(contact: RigidContact, x: np.ndarray) -> np.ndarray:
    """The mean pressure (n_face,) kPa over the whole of each face: all of them add up to the force."""
    state = contact.state(x)
    load = np.sum(state.pressure * state.areas, axis=1)
    found: np.ndarray = load / contact.rule.areas(x, contact.faces).sum(axis=1)
    return found


def path_of(found: Compression) -> pd.DataFrame:
    """The path of a compression, its area and pressures those of this module.

    contact_area_mm2: touching_area of the paddle; mean_pressure_kpa: its force over that; peak_pressure_kpa:
    the largest of face_pressures.
    """
    at_paddle = [(stage.contacts[0], stage.x) for stage in found.stages]
    area = np.array([touching_area(*each) for each in at_paddle])
    force = np.maximum(found.path.force_n.to_numpy(), 0.0) * MN_PER_N
    return found.path.assign(
        contact_area_mm2=area,
        mean_pressure_kpa=np.divide(force, area, out=np.zeros_like(area), where=area > 0),
        peak_pressure_kpa=[float(face_pressures(*each).max()) for each in at_paddle],
    )
