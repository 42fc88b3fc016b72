"""What compression does to skin and tissue: contact, pressure, strain, energy, and amounts above thresholds.

None of these is pain. Sources tie pain to pressure and to the area of contact, on average over many women
[@degroot2013; @degroot2015]; none tells which strain or which energy hurts. Area and pressures are measured
so that they hardly depend on the stiffness of the contact.
"""

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.units import MM3_PER_CM3, MN_PER_N
from mammosim.mechanics.compression import Compression
from mammosim.mechanics.effects import Effect, RigidContact
from mammosim.mechanics.reference import cell_strain, face_quadrature
from mammosim.mechanics.stress import bulk_of

MM2_PER_CM2 = 100.0
# What is measured in every cell, and what on every face of the skin.
IN_TISSUE = ("green_lagrange", "logarithmic", "energy_kpa")
ON_SKIN = ("pressure_kpa",)
# ASSUME: skin nearer to a plate than 0.1 mm is in contact with it. On elements of 14 mm that is a fifth less
# area than where the pressure is above 0 (decisions/mechanics_contact.md).
NEAR_MM = 0.1


def contact_area(contact: RigidContact, x: np.ndarray) -> float:
    """Area in mm2 of the skin, in the loaded shape x (n_node, 3), in contact with a plate."""
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

    contact_area_mm2: contact_area of the paddle; mean_pressure_kpa: its force over that; peak_pressure_kpa:
    the largest of face_pressures.
    """
    at_paddle = [(stage.contacts[0], stage.x) for stage in found.stages]
    area = np.array([contact_area(*each) for each in at_paddle])
    force = np.maximum(found.path.force_n.to_numpy(), 0.0) * MN_PER_N
    return found.path.assign(
        contact_area_mm2=area,
        mean_pressure_kpa=np.divide(force, area, out=np.zeros_like(area), where=area > 0),
        peak_pressure_kpa=[float(face_pressures(*each).max()) for each in at_paddle],
    )


def tissue_measures(mesh: TetMesh, effects: Iterable[Effect], x: np.ndarray) -> pd.DataFrame:
    """A row per cell of a body, whose mesh.points are stress-free, in the loaded shape x (n_node, 3).

    tissue: label; volume_mm3: stress-free; J; principal_1 to principal_3: Green-Lagrange strain, ascending;
    green_lagrange, logarithmic: the largest principal strain, 0 where no direction is longer than before;
    energy_kpa: elastic energy per stress-free volume, 1 kPa = 1 uJ/mm3.
    Raises MechanicsError when the effects have no bulk tissue.
    """
    strain, energy = cell_strain(mesh, x), bulk_of(effects).energies(x)
    principal = {f"principal_{i + 1}": strain.principal[:, i] for i in range(3)}
    return pd.DataFrame(
        {"tissue": mesh.tissue, "volume_mm3": strain.volume, "J": strain.J}
        | principal
        | {
            "green_lagrange": np.maximum(strain.principal[:, 2], 0.0),
            "logarithmic": np.maximum(strain.logarithmic[:, 2], 0.0),
            "energy_kpa": energy / strain.volume,
        }
    )


def skin_measures(mesh: TetMesh, plates: Mapping[str, RigidContact], x: np.ndarray) -> pd.DataFrame:
    """A row per face of the skin, in the loaded shape x (n_node, 3).

    area_mm2: loaded; {name}_kpa: the mean pressure of each plate on the face; pressure_kpa: the larger one.
    """
    areas = face_quadrature(x, mesh.boundaries["skin"]).areas.sum(axis=1)
    each = {f"{name}_kpa": face_pressures(plate, x) for name, plate in plates.items()}
    return pd.DataFrame({"area_mm2": areas} | each | {"pressure_kpa": np.max(list(each.values()), axis=0)})


def amounts_above(
    cells: pd.DataFrame, faces: pd.DataFrame, thresholds: Mapping[str, Iterable[float]]
) -> pd.DataFrame:
    """How much tissue, and how much skin, reaches each threshold of a measure.

    cells, faces: of tissue_measures and skin_measures; thresholds: IN_TISSUE or ON_SKIN -> values.
    Columns measure, threshold, tissue ('all' or its name; 'skin' of a pressure), amount, unit: 'cm3'
    (stress-free) or 'cm2' (loaded). Raises MechanicsError for an unknown measure.
    """
    rows: list[tuple[str, float, str, float, str]] = []
    for measure, values in thresholds.items():
        if measure in IN_TISSUE:
            rows += [row for value in values for row in _volumes(cells, measure, value)]
        elif measure in ON_SKIN:
            rows += [(measure, value, "skin", _area(faces, measure, value), "cm2") for value in values]
        else:
            known = ", ".join((*IN_TISSUE, *ON_SKIN))
            raise MechanicsError(f"no measure {measure!r} of discomfort; choose one of: {known}")
    return pd.DataFrame(rows, columns=["measure", "threshold", "tissue", "amount", "unit"])


def _volumes(cells: pd.DataFrame, measure: str, threshold: float) -> list[tuple[str, float, str, float, str]]:
    reached = cells[measure] >= threshold
    within = {"all": reached} | {
        Label(tissue).tissue: reached & (cells.tissue == tissue) for tissue in np.unique(cells.tissue)
    }
    return [
        (measure, threshold, name, float(cells.volume_mm3[chosen].sum() / MM3_PER_CM3), "cm3")
        for name, chosen in within.items()
    ]


def _area(faces: pd.DataFrame, measure: str, threshold: float) -> float:
    """Area in cm2 of the faces that reach a threshold."""
    return float(faces.area_mm2[faces[measure] >= threshold].sum() / MM2_PER_CM2)
