"""A body under gravity: its tissues, skin and fascia as effects, and its equilibrium."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.effects import Effect, SkinMembrane, Weight, bulk_tissue
from mammosim.mechanics.equilibrium import Equilibrium, Settings, equilibrium
from mammosim.mechanics.reference import face_quadrature
from mammosim.mechanics.soundness import faces_of


@dataclass(frozen=True)
class Skin:
    """Skin as a membrane: E [kPa] and nu [-], of which mu = E / (2 (1 + nu)) enters, and its thickness.

    thickness_mm: a number, or one per face of the boundary (n_face,).

    Raises MechanicsError when a parameter is out of range.
    """

    youngs_modulus_kpa: float
    poisson_ratio: float
    thickness_mm: float | np.ndarray
    boundary: str = "skin"

    def __post_init__(self) -> None:
        Tissue(self.youngs_modulus_kpa, self.poisson_ratio, 1.0)
        thickness = np.asarray(self.thickness_mm)
        if not (thickness.min() > 0 and thickness.max() <= 10):
            raise MechanicsError(
                f"thickness_mm from {thickness.min():g} to {thickness.max():g} is outside (0, 10]; "
                "skin has 0.5 to 3 mm, superficial fascia about 0.1 mm"
            )

    def membrane(self, mesh: TetMesh) -> SkinMembrane:
        """The membrane on the boundary of a mesh whose points are the reference.

        Raises MechanicsError when the mesh has no such boundary.
        """
        faces = faces_of(mesh, self.boundary)
        mu = self.youngs_modulus_kpa / (2 * (1 + self.poisson_ratio))
        stiffness = np.broadcast_to(mu * np.asarray(self.thickness_mm, dtype=float), (len(faces),)).copy()
        return SkinMembrane(faces, face_quadrature(mesh.points, faces), stiffness)


# ASSUME: superficial fascia is a membrane of the same law as skin, on inner faces or right under the skin.
@dataclass(frozen=True)
class Fascia(Skin):
    """Superficial fascia as a membrane, by the law of Skin, on faces inside the body: the boundary `fascia`.

    With boundary="skin" it lies right under the skin.
    """

    boundary: str = "fascia"


def body_effects(
    mesh: TetMesh,
    tissues: Mapping[Label, Tissue],
    *,
    skin: Skin | None = None,
    fascia: Fascia | None = None,
) -> tuple[Effect, ...]:
    """The elastic effects of a body whose mesh.points are the reference: its bulk, and membranes if given.

    Raises MechanicsError for a tissue of the mesh without parameters, or a membrane without its boundary.
    """
    membranes = tuple(layer.membrane(mesh) for layer in (skin, fascia) if layer is not None)
    return (bulk_tissue(mesh, tissues), *membranes)


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
