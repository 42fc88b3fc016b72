"""Effects: the terms of the potential energy. Each is a small frozen object of its own."""

from mammosim.mechanics.effects.bulk import NeoHookean
from mammosim.mechanics.effects.chest_wall import EllipticCylinder, Sliding, chest_wall_contact
from mammosim.mechanics.effects.contact import (
    SIX_POINTS,
    ContactState,
    CoulombFriction,
    FaceRule,
    Obstacle,
    RigidContact,
    six_points_in_each,
)
from mammosim.mechanics.effects.fibres import Fibres
from mammosim.mechanics.effects.mixed import MixedNeoHookean, bulk_tissue
from mammosim.mechanics.effects.network import SpringNetwork
from mammosim.mechanics.effects.plate import BentBox, RoundedBox, ShapedBox
from mammosim.mechanics.effects.plate_contact import Cushion, RigidPlate
from mammosim.mechanics.effects.protocol import Effect, Scaled
from mammosim.mechanics.effects.skin import SkinMembrane
from mammosim.mechanics.effects.small_strain import SmallStrain
from mammosim.mechanics.effects.springs import Attraction, Springs
from mammosim.mechanics.effects.weight import Buoyancy, Weight

__all__ = [
    "SIX_POINTS",
    "Attraction",
    "BentBox",
    "Buoyancy",
    "ContactState",
    "CoulombFriction",
    "Cushion",
    "Effect",
    "EllipticCylinder",
    "FaceRule",
    "Fibres",
    "MixedNeoHookean",
    "NeoHookean",
    "Obstacle",
    "RigidContact",
    "RigidPlate",
    "RoundedBox",
    "Scaled",
    "ShapedBox",
    "SkinMembrane",
    "Sliding",
    "SmallStrain",
    "SpringNetwork",
    "Springs",
    "Weight",
    "bulk_tissue",
    "chest_wall_contact",
    "six_points_in_each",
]
