"""Body positions and where gravity points in them, in the patient frame LPS."""

from collections.abc import Mapping

import numpy as np

from mammosim.core.errors import ConfigurationError

# x to the patient's left, y to posterior, z to superior.
# ASSUME: supine_tilted is a roll of 45 degrees about the long axis, towards the patient's left.
GRAVITY: Mapping[str, tuple[float, float, float]] = {
    "prone": (0.0, -1.0, 0.0),
    "supine": (0.0, 1.0, 0.0),
    "supine_tilted": (np.sqrt(0.5), np.sqrt(0.5), 0.0),
    "upright": (0.0, 0.0, -1.0),
}


def gravity_direction(position: str) -> np.ndarray:
    """Unit vector (3,) of gravity. Raises ConfigurationError for an unknown position."""
    if position not in GRAVITY:
        raise ConfigurationError(f"unknown position {position!r}; choose one of: {', '.join(GRAVITY)}")
    return np.array(GRAVITY[position])


def gravity_vector(text: str) -> np.ndarray:
    """Unit vector (3,) of 'x y z'. Raises ValueError for anything else."""
    g = np.array([float(value) for value in text.split()])
    if g.shape != (3,) or not np.all(np.isfinite(g)) or not np.linalg.norm(g) > 0:
        raise ValueError(text)
    found: np.ndarray = g / np.linalg.norm(g)
    return found
