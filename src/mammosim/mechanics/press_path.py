"""What happened on the way of a compression, one row for each step, and how another one begins from it."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mammosim.core.units import MN_PER_N
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.press import Press
from mammosim.mechanics.stage import Stage


@dataclass(frozen=True)
class WarmStart:
    """A stage between rigid plates, as it may be kept in a file.

    thickness: of the plates, mm; penalty: of their contacts, kPa/mm; x (n_node, 3) mm; multipliers
    (2, n_face, 6) kPa of paddle and support, see RigidPlate.
    """

    thickness: float
    penalty: float
    x: np.ndarray
    multipliers: np.ndarray

    def stage(self, press: Press) -> Stage:
        """The same stage of a press, its paddle at rest."""
        paddle, support = (
            replace(contact, obstacle=box, penalty=self.penalty, multiplier=multiplier)
            for contact, box, multiplier in zip(
                press.apart, press.plates.at(self.thickness), self.multipliers
            )
        )
        return Stage(self.thickness, press.plates.at_rest, self.x, (paddle, support))


def force_n(stage: Stage, axis: np.ndarray) -> float:
    """Of the skin on the paddle along the axis (3,) from the support to the paddle, with friction, N."""
    return _on_plates(stage, axis)[0]


def path_table(press: Press, stages: list[Stage]) -> pd.DataFrame:
    """The path of a Compression, see there."""
    path = pd.DataFrame([_row(press, stage) for stage in stages])
    pressing = (path.force_n + path.support_force_n) / 2 * MN_PER_N
    done = -(pressing + pressing.shift()) / 2 * path.readout_mm.diff()
    return path.assign(work_uj=done.fillna(0.0).cumsum())


def _row(press: Press, stage: Stage) -> dict[str, float]:
    plates, x = press.plates, stage.x
    paddle, support = (contact.state(x) for contact in stage.contacts)
    force, support_force = _on_plates(stage, plates.axes[:, 2])
    stiffness = plates.paddle.stiffness(plates.half_sizes)
    potential = Potential((*press.effects, *stage.surroundings()))
    return {
        "thickness_mm": float(plates.gap(plates.middle[None], stage.thickness, stage.q)[0]),
        "readout_mm": stage.thickness,
        "force_n": force,
        "support_force_n": support_force,
        "chest_force_n": _chest_force_n(press, stage),
        "contact_area_mm2": paddle.area,
        "mean_pressure_kpa": force * MN_PER_N / paddle.area if paddle.area > 0 else 0.0,
        "peak_pressure_kpa": float(paddle.face_pressure.max()),
        "penalty_kpa_per_mm": stage.contacts[0].penalty,
        "penetration_mm": max(paddle.penetration, support.penetration),
        "tilt_deg": plates.paddle.tilt_deg(stage.q),
        "deflection_mm": plates.deflection_mm(stage.q),
        "energy_uj": potential.energy(x) + float(stage.q @ stiffness @ stage.q) / 2,
        "dissipated_uj": stage.dissipated,
        "smallest_J": potential.smallest_J(x),
        "iterations": len(stage.history),
        "seconds": stage.seconds,
    }


def _on_plates(stage: Stage, axis: np.ndarray) -> tuple[float, float]:
    """Forces of the skin on paddle and support, outward along the axis, N."""
    contact, friction = stage.contacts, stage.surroundings()[2:]
    paddle, support = (
        float(Potential((contact[i], *friction[i : i + 1])).gradient(stage.x).sum(axis=0) @ axis) / MN_PER_N
        for i in range(2)
    )
    return paddle, -support


def _chest_force_n(press: Press, stage: Stage) -> float:
    """Along the axis on the body: by what is held, and by all effects but the plates, N.

    Forces within the body sum to zero; chest wall, loose tissue and weight remain.
    """
    others = Potential(press.effects).gradient(stage.x)
    whole = others + Potential(stage.surroundings()).gradient(stage.x)
    force = np.where(press.system.held, whole, 0.0).sum(axis=0) - others.sum(axis=0)
    return float(force @ press.plates.axes[:, 2]) / MN_PER_N
