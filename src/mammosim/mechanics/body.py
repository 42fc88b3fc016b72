"""A body under gravity: its tissues and skin as effects, and its equilibrium."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.effects import Effect, NeoHookean, SkinMembrane, Weight
from mammosim.mechanics.equilibrium import Equilibrium, Settings, equilibrium
from mammosim.mechanics.reference import face_quadrature


@dataclass(frozen=True)
class Skin:
    """Skin as a membrane: E [kPa] and nu [-], of which mu = E / (2 (1 + nu)) enters, and its thickness.

    thickness_mm: a number, or one per face of the boundary `skin` (n_face,).

    Raises MechanicsError when a parameter is out of range.
    """

    youngs_modulus_kpa: float
    poisson_ratio: float
    thickness_mm: float | np.ndarray

    def __post_init__(self) -> None:
        Tissue(self.youngs_modulus_kpa, self.poisson_ratio, 1.0)
        thickness = np.asarray(self.thickness_mm)
        if thickness.min() <= 0 or thickness.max() > 10:
            raise MechanicsError(
                f"thickness_mm from {thickness.min():g} to {thickness.max():g} is outside (0, 10]; "
                "skin has 0.5 to 3 mm"
            )

    def membrane(self, mesh: TetMesh) -> SkinMembrane:
        """The membrane on the boundary `skin` of a mesh whose points are the reference."""
        faces = mesh.boundaries["skin"]
        mu = self.youngs_modulus_kpa / (2 * (1 + self.poisson_ratio))
        stiffness = np.broadcast_to(mu * np.asarray(self.thickness_mm, dtype=float), (len(faces),)).copy()
        return SkinMembrane(faces, face_quadrature(mesh.points, faces), stiffness)


def body_effects(
    mesh: TetMesh, tissues: Mapping[Label, Tissue], *, skin: Skin | None = None
) -> tuple[Effect, ...]:
    """The elastic effects of a body whose mesh.points are the reference: its bulk, and its skin if given.

    Raises MechanicsError for a tissue of the mesh without parameters.
    """
    bulk = NeoHookean.of(mesh, tissues)
    return (bulk,) if skin is None else (bulk, skin.membrane(mesh))


def load(
    mesh: TetMesh,
    tissues: Mapping[Label, Tissue],
    gravity: np.ndarray,
    *,
    skin: Skin | None = None,
    start: np.ndarray | None = None,
    settings: Settings | None = None,
) -> Equilibrium:
    """The equilibrium under gravity, unit vector (3,), of a body whose mesh.points are stress-free.

    Raises MechanicsError for an ill-posed problem, EquilibriumError when no verified equilibrium was reached.
    """
    effects = body_effects(mesh, tissues, skin=skin)
    weight = Weight.of(mesh, tissues, gravity)
    return equilibrium(mesh, effects, loads=(weight,), start=start, settings=settings)
