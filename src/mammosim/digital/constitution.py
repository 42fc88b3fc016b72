"""The mechanical parameters of a virtual patient, left and right apart: the moduli that a fit has to find."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import WITH_MODULUS, Membrane, Tissue, TissueTable
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.patient import Moduli, SideModuli, VirtualPatient
from mammosim.mechanics.body import SIDES, Body, Ligaments, Skin, sided_body

MIDDLE_MM = 0.0  # x of the plane between her sides, in the body frame
SOLIDS = ("adipose", "glandular", "muscle")


@dataclass(frozen=True)
class Constitution:
    """moduli_kpa: E [kPa] of either side; nu [-] by tissue, skin among them; density [g/cm3] by solid."""

    moduli_kpa: Moduli
    poisson_ratio: Mapping[str, float]
    density_g_cm3: Mapping[str, float]
    ligaments: Ligaments | None = None

    @classmethod
    def of(cls, patient: VirtualPatient, common: TissueTable) -> "Constitution":
        """Of a virtual patient and what all have in common, whose moduli she has unless she has her own.

        Raises ConfigurationError where the table lacks the skin or one of SOLIDS.
        """
        skin = {} if common.skin is None else {"skin": common.skin}
        parts: Mapping[str, Tissue | Membrane] = {**common.tissues, **skin}
        if lacking := sorted({*SOLIDS, "skin"} - set(parts)):
            raise ConfigurationError(
                f"the tissues of virtual patients lack {', '.join(lacking)}; add them to the file "
                "of digital.tissues"
            )
        alike = SideModuli(**{name: parts[name].youngs_modulus_kpa for name in (*SOLIDS, "skin")})
        return cls(
            patient.moduli_kpa or Moduli(alike, alike),
            {name: part.poisson_ratio for name, part in parts.items()},
            {name: tissue.density_g_cm3 for name, tissue in common.tissues.items()},
            patient.ligaments,
        )

    def body(self, anatomy: Anatomy, mesh: TetMesh) -> Body:
        """Her body on a mesh of her stress-free shape, its skin of regional thickness.

        Raises MechanicsError for an impossible modulus, or a mesh without skin.
        """
        # ASSUME: the truth differs from the reconstruction in mesh, regional skin, stiffer gland, lower nu.
        centres = mesh.points[mesh.boundaries["skin"]].mean(axis=1)
        thickness = anatomy.skin_thickness(centres)
        skins = {
            side: Skin(self.moduli_kpa.of(side).skin, self.poisson_ratio["skin"], thickness) for side in SIDES
        }
        sides = sided_body(mesh, {side: self._tissues(side) for side in SIDES}, skins, middle_mm=MIDDLE_MM)
        return Body(sides.tissues, (*sides.parts, *([self.ligaments] if self.ligaments else [])))

    def moduli(self) -> pd.DataFrame:
        """Her true moduli: side, tissue, true_kpa, which is 0 for what she does not have."""
        # ASSUME: digital volunteers have no superficial fascia.
        each = {side: asdict(self.moduli_kpa.of(side)) for side in SIDES}
        rows = [(side, name, each[side].get(name, 0.0)) for side in SIDES for name in WITH_MODULUS]
        return pd.DataFrame(rows, columns=["side", "tissue", "true_kpa"])

    def _tissues(self, side: str) -> dict[Label, Tissue]:
        E, nu, density = asdict(self.moduli_kpa.of(side)), self.poisson_ratio, self.density_g_cm3
        return {Label[name.upper()]: Tissue(E[name], nu[name], density[name]) for name in SOLIDS}
