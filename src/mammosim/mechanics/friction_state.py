"""Where skin sticks to a plate, from one step of a compression to the next."""

# ASSUME: skin that comes into contact within a step begins to stick where it is at the end of that step.

from dataclasses import dataclass, replace

import numpy as np

from mammosim.mechanics.effects import CoulombFriction, RigidPlate
from mammosim.mechanics.paddles import Friction


@dataclass(frozen=True)
class FrictionState:
    """anchors (n_face, n_q, 3) mm: where points stick, in the coordinates of the plate; sticks: which do.

    load (n_face, n_q) mN and normals (n_face, n_q, 3): of the last shape whose normal forces are known.
    """

    law: Friction
    anchors: np.ndarray
    sticks: np.ndarray
    load: np.ndarray
    normals: np.ndarray

    @classmethod
    def none(cls, law: Friction, contact: RigidPlate) -> "FrictionState":
        """Before any contact."""
        shape = contact.areas.shape
        empty = np.zeros((*shape, 3))
        return cls(law, empty, np.zeros(shape, dtype=bool), np.zeros(shape), empty)

    def lagged(self, contact: RigidPlate, x: np.ndarray) -> "FrictionState":
        """The same state under the normal forces that a plate has in the shape x (n_node, 3)."""
        y, p = contact.pressures(x)
        n = contact.obstacle.normal(y.reshape(-1, 3)).reshape(y.shape)
        n /= np.linalg.norm(n, axis=-1, keepdims=True)
        load = contact.areas * p * self.sticks
        return replace(self, load=load, normals=n)

    def effect(self, contact: RigidPlate) -> CoulombFriction:
        """The friction of this state on a plate, wherever that has moved."""
        places = contact.obstacle.position(self.anchors.reshape(-1, 3)).reshape(self.anchors.shape)
        load = self.law.coefficient * self.load
        return CoulombFriction(contact.faces, contact.rule, load, self.normals, places, self.law.slip_mm)

    def carried(self, contact: RigidPlate, x: np.ndarray) -> tuple["FrictionState", float]:
        """The state after a step that ended at x, and what it dissipated, uJ: anchors are dragged along.

        The force mu lambda on an anchor has the direction in which it is dragged, so that no work is gained.
        """
        y, p = contact.pressures(x)
        friction = self.effect(contact)
        s, length = friction.slips(x)
        dragged = np.maximum(length - self.law.slip_mm, 0.0)
        places = friction.places + (dragged / np.maximum(length, 1e-300))[..., None] * s
        sticks = p > 0
        places = np.where((self.sticks & sticks)[..., None], places, y)
        anchors = contact.obstacle.material(places.reshape(-1, 3)).reshape(places.shape)
        after = replace(self, anchors=anchors, sticks=sticks)
        return after, float(np.sum(friction.load * dragged))
