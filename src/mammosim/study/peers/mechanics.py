"""The hanging hemisphere as a problem for several programs: the same mesh, law, load and residual for all."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.settings import Count, Limits, Positive, Settings, read
from mammosim.core.tissues import Tissue
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.io.tabulated import tabulated
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.effects import NeoHookean, Weight
from mammosim.mechanics.potential import Potential
from mammosim.meshing.shapes import ball_part, with_layer

DISPLACEMENTS, WITH_PRESSURE = "displacements", "continuous pressure"
RADIUS_MM, DENSITY_G_CM3 = 60.0, 1.0
AWAY_FROM_THE_HELD_FACE = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Case(Settings):
    """One material: E [kPa], nu [-]; skin as a layer of solid elements, as a membrane, or none.

    reference: a case of the table hemisphere_gravity, whose apex it should have; load_steps: how many equal
    ones a program begins with, one unless stated.
    """

    youngs_modulus_kpa: Positive
    poisson_ratio: Annotated[float, Limits(at_least=0, below=0.5)]
    layer: Skin | None = None
    membrane: Skin | None = None
    reference: str | None = None
    load_steps: Mapping[str, Count] = field(default_factory=dict)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> "Case":
        """A case as configured. Raises ConfigurationError for a key or value that cannot be."""
        case: Case = read(cls, values, "case")
        return case

    @property
    def tissues(self) -> dict[Label, Tissue]:
        """The layer is as dense as the tissue under it."""
        tissues = {Label.ADIPOSE: Tissue(self.youngs_modulus_kpa, self.poisson_ratio, DENSITY_G_CM3)}
        if self.layer is not None:
            E = float(self.layer.youngs_modulus_kpa)
            layer = Tissue(E, self.layer.poisson_ratio, DENSITY_G_CM3)
            tissues[Label.SKIN] = layer
        return tissues

    def potential(self, mesh: TetMesh, *, displacements_only: bool) -> Potential:
        """The potential energy under gravity away from the held face.

        displacements_only: as other programs have it, where this package would add a pressure near nu = 1/2.
        """
        weight = Weight.of(mesh, self.tissues, AWAY_FROM_THE_HELD_FACE)
        if displacements_only:
            return Potential((NeoHookean.of(mesh, self.tissues),), (weight,))
        return Potential(body_effects(mesh, self.tissues, skin=self.membrane), (weight,))

    def error_percent(self, apex_mm: float) -> float:
        """Of an apex, against the reference; nan without one."""
        if self.reference is None:
            return np.nan
        table = tabulated("hemisphere_gravity").set_index("case")
        return 100 * abs(apex_mm / float(table.apex_mm[self.reference]) - 1)

    def facts(self) -> dict[str, Any]:
        """What a program needs to know, in plain values: mu and k [kPa] by label, weight [kPa/mm]."""
        membrane = self.membrane
        return {
            "mu_kpa": {str(int(label)): tissue.shear_modulus_kpa for label, tissue in self.tissues.items()},
            "k_kpa": {str(int(label)): tissue.bulk_modulus_kpa for label, tissue in self.tissues.items()},
            "weight": KPA_PER_MM_PER_G_CM3 * DENSITY_G_CM3,
            "tissues": {label.tissue: vars(tissue) for label, tissue in self.tissues.items()},
            "membrane": None if membrane is None else vars(membrane),
        }


def hemisphere(edge_mm: float, *, layer_mm: float = 0.0) -> TetMesh:
    """Half a ball of RADIUS_MM, held at z = 0; of layer_mm > 0 the outermost is one layer of elements, SKIN.

    Raises MeshError for an edge_mm that does not fit.
    """
    inner = RADIUS_MM - layer_mm
    mesh = ball_part(inner, edge_mm)
    return with_layer(mesh, mesh.points * RADIUS_MM / inner) if layer_mm else mesh


def result(case: Case, mesh: TetMesh, u: np.ndarray | None, *, displacements_only: bool) -> dict[str, Any]:
    """Of the displacements u (n_node, 3) mm: how far the apex moved [mm], its error, the residual.

    All nan where a program found none.

    residual: norm of the free forces over that of the weight on them, by this package for every program.
    """
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior")] = True
    unknowns = int((~held).sum())
    if u is None:
        nothing = dict.fromkeys(("apex_mm", "error_percent", "residual"), np.nan)
        return {"law": "", "unknowns": unknowns, **nothing}
    potential = case.potential(mesh, displacements_only=displacements_only)
    x = mesh.points + u
    free = np.linalg.norm(potential.gradient(x)[~held])
    weight = np.linalg.norm(potential.gradient(mesh.points)[~held])
    apex_mm = float(u[np.argmax(mesh.points[:, 2]), 2])
    return {
        "law": DISPLACEMENTS if isinstance(potential.effects[0], NeoHookean) else WITH_PRESSURE,
        "unknowns": unknowns,
        "apex_mm": apex_mm,
        "error_percent": case.error_percent(apex_mm),
        "residual": float(free / weight),
    }
