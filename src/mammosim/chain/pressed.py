"""What one strategy did to one breast: its row of compression.csv, and the tables beside it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.discomfort import amounts_above, skin_measures, tissue_measures
from mammosim.chain.outcome import CONVERGED
from mammosim.chain.plates import plate_facts
from mammosim.chain.strategies import PressSetup
from mammosim.chain.thickness import thickness_map
from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.units import UJ_PER_MJ
from mammosim.mechanics.compression import Compression

# Columns of a row that are those of the last step of the path.
LAST = ("force_n", "support_force_n", "chest_force_n", "contact_area_mm2", "mean_pressure_kpa",
        "peak_pressure_kpa", "penetration_mm", "tilt_deg", "deflection_mm", "smallest_J")  # fmt: skip
PATH = ("thickness_mm", "readout_mm", *LAST, "energy_uj", "work_uj", "iterations", "seconds")
MEASURED = ("plates_mm", "thickness_mm", "thickness_min_mm", "thickness_max_mm", *LAST, "imbalance_percent",
            "green_lagrange_p95", "logarithmic_p95", "energy_kpa_p95", "energy_mj", "work_mj",
            "seconds")  # fmt: skip
AMOUNTS = ("measure", "threshold", "tissue", "amount", "unit")


@dataclass(frozen=True)
class Pressed:
    """A breast between the plates: its mesh, pressed, and its tables.

    path: see mechanics.compression.Compression; cells, faces, amounts: chain.discomfort; thickness:
    chain.thickness; row: MEASURED and the outcome; plates: chain.plates.plate_facts.
    """

    mesh: TetMesh
    path: pd.DataFrame
    cells: pd.DataFrame
    faces: pd.DataFrame
    amounts: pd.DataFrame
    thickness: pd.DataFrame
    row: Mapping[str, float | str]
    plates: Mapping[str, float]


def pressed_breast(setup: PressSetup, found: Compression, thresholds: Mapping[str, list[float]]) -> Pressed:
    """The tables of a compression; thresholds: see chain.discomfort.amounts_above.

    Raises MechanicsError where the paddle does not touch the breast in the end.
    """
    _require_contact(found)
    mesh, x = setup.mesh, found.points
    cells = tissue_measures(mesh, setup.effects, x)
    faces = skin_measures(mesh, dict(zip(("paddle", "support"), found.plates)), x)
    return Pressed(
        mesh=mesh.moved_to(x),
        path=found.path,
        cells=cells,
        faces=faces,
        amounts=amounts_above(cells, faces, thresholds),
        thickness=thickness_map(mesh.moved_to(x), setup.plates),
        row=_row(setup, found, cells, faces),
        plates=plate_facts(
            setup.plates,
            float(found.path.readout_mm.iloc[-1]),
            widest_mm=float(np.nanmax(found.gap(x[mesh.boundary_nodes("skin")]))),
        ),
    )


def _require_contact(found: Compression) -> None:
    """Raise MechanicsError for a state that no image is taken of: nothing is held between the plates."""
    last = found.path.iloc[-1]
    if not last.force_n > 0:
        raise MechanicsError(
            f"{last.readout_mm:.1f} mm above the support the paddle does not touch the breast, which is "
            "thinner or has slipped out on the way; ask for less thickness, or raise compression.steps"
        )


def _row(
    setup: PressSetup, found: Compression, cells: pd.DataFrame, faces: pd.DataFrame
) -> dict[str, float | str]:
    """MEASURED, and the outcome.

    plates_mm: the distance that the machine reads; thickness_*: of the faces that the paddle touches, by
    area: the middle one (median), the least and the greatest; *_p95: 95 % of the tissue under the plates has
    less; imbalance_percent: what paddle, support and chest wall leave of each other, of the paddle's force.
    """
    last = found.path.iloc[-1]
    gap = _gap_at_paddle(setup.mesh, found, faces)
    under = cells[_under_plates(setup, found.points)]
    imbalance = last.force_n - last.support_force_n - last.chest_force_n
    return {
        "plates_mm": float(last.readout_mm),
        "thickness_mm": quantile(gap.gap_mm, gap.area_mm2, 0.5),
        "thickness_min_mm": float(gap.gap_mm.min()),
        "thickness_max_mm": float(gap.gap_mm.max()),
        **{name: float(last[name]) for name in LAST},
        "imbalance_percent": float(100 * abs(imbalance) / last.force_n),
        **{
            f"{measure}_p95": quantile(under[measure], under.volume_mm3, 0.95)
            for measure in ("green_lagrange", "logarithmic", "energy_kpa")
        },
        "energy_mj": float(last.energy_uj / UJ_PER_MJ),
        "work_mj": float(last.work_uj / UJ_PER_MJ),
        "seconds": float(found.path.seconds.sum()),
        "outcome": CONVERGED,
    }


def _gap_at_paddle(mesh: TetMesh, found: Compression, faces: pd.DataFrame) -> pd.DataFrame:
    """gap_mm between the plates at the middle of each face that the paddle touches, with its area_mm2."""
    touching = (faces.paddle_kpa > 0).to_numpy()
    middles = found.points[mesh.boundaries["skin"][touching, :3]].mean(axis=1)
    rows = pd.DataFrame({"gap_mm": found.gap(middles), "area_mm2": faces.area_mm2[touching].to_numpy()})
    return rows.dropna()


def _under_plates(setup: PressSetup, x: np.ndarray) -> np.ndarray:
    """Whether the middle of each cell is before the plates' chest edge and between their sides (n_cell,)."""
    plates = setup.plates
    y = (x[setup.mesh.cells[:, :4]].mean(axis=1) - plates.centre) @ plates.axes
    found: np.ndarray = np.all(np.abs(y[:, :2]) <= plates.half_sizes[:2], axis=1)
    return found


def quantile(values: pd.Series, weights: pd.Series, share: float) -> float:
    """The value below which `share` of the weight lies; NaN of nothing."""
    if len(values) == 0:
        return float("nan")
    order = np.argsort(values.to_numpy())
    below = np.cumsum(weights.to_numpy()[order]) / weights.sum()
    return float(values.to_numpy()[order][min(np.searchsorted(below, share), len(order) - 1)])
