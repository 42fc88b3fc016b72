"""What a digital volunteer is made of, left and right apart: the moduli that a fit has to find."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import WITH_MODULUS, Tissue
from mammosim.digital.anatomy import Anatomy
from mammosim.mechanics.body import SIDES, Body, Ligaments, Skin, sided_body

MIDDLE_MM = 0.0  # x of the plane between her sides, in the body frame
SOLIDS = ("adipose", "glandular", "muscle")


@dataclass(frozen=True)
class Constitution:
    """moduli_kpa: E [kPa] by side and tissue, skin among them; nu [-] by tissue; density [g/cm3] by solid.

    Raises ConfigurationError for a side or a tissue without modulus, or one that is unknown.
    """

    moduli_kpa: Mapping[str, Mapping[str, float]]
    poisson_ratio: Mapping[str, float]
    density_g_cm3: Mapping[str, float]
    ligaments: Ligaments | None = None

    def __post_init__(self) -> None:
        for side in SIDES:
            given, wanted = set(self.moduli_kpa.get(side, ())), {*SOLIDS, "skin"}
            if given != wanted:
                raise ConfigurationError(
                    f"moduli_kpa.{side}: missing {sorted(wanted - given)}, unknown {sorted(given - wanted)}; "
                    f"give exactly: {', '.join(sorted(wanted))}"
                )

    @classmethod
    def from_parameters(cls, woman: Mapping[str, Any], common: Mapping[str, Any]) -> "Constitution":
        """Of nested plain values: a woman's, and a table {tissues, skin} of what all women have in common.

        woman: may have moduli_kpa, {left: {adipose, glandular, skin, muscle}, right: {...}}, in place of the
        common ones, and ligaments, {stiffness_kpa}.
        """
        parts = {**common["tissues"], "skin": common["skin"]}
        alike = {name: part["youngs_modulus_kpa"] for name, part in parts.items()}
        return cls(
            woman.get("moduli_kpa", dict.fromkeys(SIDES, alike)),
            {name: part["poisson_ratio"] for name, part in parts.items()},
            {name: part["density_g_cm3"] for name, part in common["tissues"].items()},
            Ligaments(**woman["ligaments"]) if "ligaments" in woman else None,
        )

    def body(self, anatomy: Anatomy, mesh: TetMesh) -> Body:
        """Her body on a mesh of her stress-free shape, its skin of regional thickness.

        Raises MechanicsError for an impossible modulus, or a mesh without skin.
        """
        # ASSUME: the truth differs from the reconstruction in mesh, regional skin, stiffer gland, lower nu.
        centres = mesh.points[mesh.boundaries["skin"]].mean(axis=1)
        thickness = anatomy.skin_thickness(centres)
        skins = {
            side: Skin(self.moduli_kpa[side]["skin"], self.poisson_ratio["skin"], thickness) for side in SIDES
        }
        sides = sided_body(mesh, {side: self._tissues(side) for side in SIDES}, skins, middle_mm=MIDDLE_MM)
        return Body(sides.tissues, (*sides.parts, *([self.ligaments] if self.ligaments else [])))

    def moduli(self) -> pd.DataFrame:
        """Her true moduli: side, tissue, true_kpa, which is 0 for what she does not have."""
        # ASSUME: digital volunteers have no superficial fascia.
        rows = [(side, name, self.moduli_kpa[side].get(name, 0.0)) for side in SIDES for name in WITH_MODULUS]
        return pd.DataFrame(rows, columns=["side", "tissue", "true_kpa"])

    def _tissues(self, side: str) -> dict[Label, Tissue]:
        E, nu, density = self.moduli_kpa[side], self.poisson_ratio, self.density_g_cm3
        return {Label[name.upper()]: Tissue(E[name], nu[name], density[name]) for name in SOLIDS}
