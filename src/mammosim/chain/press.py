"""The breast between the plates: by the standard strategy, and by the strategy of the load.

Its effects are weight and friction.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.conditions import uses_standard
from mammosim.chain.discomfort import amounts_above, skin_measures, tissue_measures
from mammosim.chain.fields import Fields, fields_of
from mammosim.chain.graph import Inputs
from mammosim.chain.outcome import CONVERGED
from mammosim.chain.plates import PlateSize, craniocaudal_plates, plate_facts, thickness_map
from mammosim.chain.points import MaterialPoints
from mammosim.chain.strategies import LoadPath, NoStandard, PressedState, PressSetup, Strategy, ThicknessShare
from mammosim.chain.thickness import StandardThickness, chosen_thickness
from mammosim.chain.unloaded import pressed_factor
from mammosim.core.errors import MammosimError, MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.core.positions import gravity_direction
from mammosim.core.settings import NotNegative, Positive, looked_up, read, require_positive
from mammosim.core.units import UJ_PER_MJ
from mammosim.io.meshes import read_mesh, read_point_data, read_skin_data, write_mesh
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.mechanics.paddles import Friction, Rigid
from mammosim.mechanics.stage import PressSettings

# Columns of a row that are those of the last step of the path.
LAST = ("force_n", "support_force_n", "chest_force_n", "contact_area_mm2", "mean_pressure_kpa",
        "peak_pressure_kpa", "penetration_mm", "tilt_deg", "deflection_mm", "smallest_J")  # fmt: skip
PATH = ("thickness_mm", "readout_mm", *LAST, "energy_uj", "work_uj", "iterations", "seconds")
MEASURED = ("plates_mm", "thickness_mm", "thickness_min_mm", "thickness_max_mm", *LAST, "imbalance_percent",
            "green_lagrange_p95", "logarithmic_p95", "energy_kpa_p95", "energy_mj", "work_mj",
            "seconds", "thickness_from", "chest_gap_mm", "chest_gap_from", "moduli_factor")  # fmt: skip
AMOUNTS = ("measure", "threshold", "tissue", "amount", "unit")


@dataclass(frozen=True)
class Pressed:
    """A breast between the plates: its mesh, pressed, and its tables.

    path: see mechanics.compression.Compression; cells, faces, amounts: chain.discomfort; thickness and
    plates: chain.plates; row: MEASURED and the outcome; fields: chain.fields, to look at.
    """

    mesh: TetMesh
    path: pd.DataFrame
    cells: pd.DataFrame
    faces: pd.DataFrame
    amounts: pd.DataFrame
    thickness: pd.DataFrame
    row: Mapping[str, float | str]
    plates: Mapping[str, float]
    fields: Fields = field(default_factory=Fields)


def pressed_breast(
    setup: PressSetup, found: PressedState, thresholds: Mapping[str, Iterable[float]]
) -> Pressed:
    """The tables of a compression; thresholds: see chain.discomfort.amounts_above.

    Raises MechanicsError where paddle and breast are not in contact in the end.
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
            room_mm=found.room(x[mesh.boundary_nodes("skin")]),
        ),
        fields=fields_of(mesh, setup.effects, x),
    )


def _require_contact(found: PressedState) -> None:
    """Raise MechanicsError where nothing is held between the plates, of which no image is taken."""
    last = found.path.iloc[-1]
    if not last.force_n > 0:
        raise MechanicsError(
            f"{last.readout_mm:.1f} mm above the support the paddle has no contact with the breast, which "
            "is thinner or has slipped out on the way; ask for less thickness, or raise compression.steps"
        )


def _row(
    setup: PressSetup, found: PressedState, cells: pd.DataFrame, faces: pd.DataFrame
) -> dict[str, float | str]:
    """MEASURED, and the outcome.

    plates_mm: the distance that the machine reads; thickness_*: of the faces in contact with the paddle, by
    area: the middle one (median), the least and the greatest; *_p95: 95 % of the tissue under the plates has
    less; imbalance_percent: what paddle, support and chest wall leave of each other, of the paddle's force;
    thickness_from: chain.thickness.StandardThickness.origin; chest_gap_mm, chest_gap_from:
    chain.plates.PlacedPlates; moduli_factor: see chain.stress_free.
    """
    last = found.path.iloc[-1]
    gap = _gap_at_paddle(setup.mesh, found, faces)
    under = cells[_under_plates(setup.mesh, found)]
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
        "thickness_from": setup.thickness_from,
        "chest_gap_mm": setup.chest_gap_mm,
        "chest_gap_from": setup.chest_gap_from,
        "moduli_factor": setup.moduli_factor,
        "outcome": CONVERGED,
    }


def _gap_at_paddle(mesh: TetMesh, found: PressedState, faces: pd.DataFrame) -> pd.DataFrame:
    """gap_mm between the plates at the middle of each face in contact with the paddle, with its area_mm2."""
    touching = (faces.paddle_kpa > 0).to_numpy()
    middles = found.points[mesh.boundaries["skin"][touching, :3]].mean(axis=1)
    rows = pd.DataFrame({"gap_mm": found.gap(middles), "area_mm2": faces.area_mm2[touching].to_numpy()})
    return rows.dropna()


def _under_plates(mesh: TetMesh, found: PressedState) -> np.ndarray:
    """Whether the middle of each cell is before the plates' chest edge and between their sides (n_cell,)."""
    under: np.ndarray = ~np.isnan(found.gap(found.points[mesh.cells[:, :4]].mean(axis=1)))
    return under


def quantile(values: pd.Series, weights: pd.Series, share: float) -> float:
    """The value below which `share` of the weight lies; NaN of nothing."""
    if len(values) == 0:
        return float("nan")
    order = np.argsort(values.to_numpy())
    below = np.cumsum(weights.to_numpy()[order]) / weights.sum()
    return float(values.to_numpy()[order][min(np.searchsorted(below, share), len(order) - 1)])


# ASSUME: a woman stands while her breast is pressed.
STANDING = "upright"


@dataclass(frozen=True)
class CompressionSettings:
    """`compression`: the plates; chest_gap_mm from the ribs to their edge, None for one that
    is chosen (chain.plates); and how a path is solved.

    depth_share: see chain.thickness; smallest_mm: no strategy presses further; steps: of the path from first
    contact; penetration_mm: how far pressed skin may be from a plate, on average over a part of a face.
    """

    plate_mm: PlateSize
    chest_gap_mm: NotNegative | None
    depth_share: float
    smallest_mm: float
    steps: int
    penetration_mm: float

    def __post_init__(self) -> None:
        require_positive(self, "depth_share", "smallest_mm", "steps", "penetration_mm")


@dataclass(frozen=True)
class Load:
    """`load`: the name of the moduli that are pressed, and the standard strategy's thickness, if given."""

    moduli: str
    thickness_mm: Positive | None


def press_setup(inputs: Inputs) -> PressSetup:
    """The stress-free breast before the plates."""
    rest, body, measured = inputs["stress_free"].mesh, inputs["pressed_body"], inputs["mesh"]
    breast: Breast = inputs["breast"]
    hanging = breast.to_reference(breast.nipple[None])
    nipple = MaterialPoints.on(measured, hanging).carry(rest.points)[0]
    given = looked_up(CompressionSettings, inputs.setting, "compression")
    placed = craniocaudal_plates(rest, nipple, plate_mm=given.plate_mm, chest_gap_mm=given.chest_gap_mm)
    plates = placed.plates
    effects = body.effects(rest)
    if inputs.has("weight"):
        effects += (body.weight(rest, gravity_direction(STANDING)),)
    if inputs.has("friction"):
        friction = read(Friction, inputs.setting("effects.friction"), "effects.friction")
        plates = replace(plates, friction=friction)
    load = looked_up(Load, inputs.setting, "load")
    standard = _standard_thickness(load, given, measured, hanging[0])
    return PressSetup(
        rest,
        effects,
        plates,
        load.moduli,
        thickness_mm=standard.mm,
        thickness_from=standard.origin,
        chest_gap_mm=placed.gap_mm,
        chest_gap_from=placed.origin,
        moduli_factor=pressed_factor(inputs),
        smallest_mm=given.smallest_mm,
        solved=PressSettings(steps=given.steps, penetration_mm=given.penetration_mm),
        held=body.held(rest),
    )


def _standard_thickness(
    load: Load, given: CompressionSettings, measured: TetMesh, nipple: np.ndarray
) -> StandardThickness:
    """As given, or chosen by the breast as it was measured."""
    if load.thickness_mm is not None:
        return StandardThickness(load.thickness_mm)
    return chosen_thickness(measured, nipple, share=given.depth_share, smallest_mm=given.smallest_mm)


def standard_path(inputs: Inputs) -> LoadPath:
    """The load path of the standard strategy, which others are compared with and continue."""
    setup: PressSetup = inputs["press_setup"]
    return LoadPath.of(setup.mesh, ThicknessShare(1.0).press(setup, Rigid()))


def save_standard_path(found: LoadPath, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The shapes of all steps as point data of one mesh of their last, and their table."""
    write_mesh(found.mesh, files["shapes"], point_data=found.point_data(), skin_data=found.skin_data())
    write_table(found.path, files["path"])


def load_standard_path(files: Mapping[str, str]) -> LoadPath:
    """What save_standard_path wrote."""
    mesh, path = read_mesh(files["shapes"]), read_table(files["path"])
    names = LoadPath.names(len(path))
    shapes = [read_point_data(files["shapes"], name) for name in names]
    on_faces = np.array([read_skin_data(files["shapes"], name) for name in names])
    multipliers = np.moveaxis(on_faces.reshape(*on_faces.shape[:2], 2, 6), 2, 1)
    return LoadPath(path, np.array(shapes), multipliers, mesh)


def pressed(inputs: Inputs) -> Pressed:
    """The breast between the plates, where the strategy of the load ends.

    The standard strategy ends where its load path does, and others continue that path. Where it found no
    equilibrium, a strategy that does not need it is pressed from first contact.
    """
    strategy, setup = (
        Strategy.read(inputs.setting("load.strategy"), at="load.strategy"),
        inputs["press_setup"],
    )
    thresholds = read(
        Mapping[str, tuple[float, ...]], inputs.setting("compression.thresholds"), "compression.thresholds"
    )
    if strategy == Strategy(Rigid(), ThicknessShare(1.0)):
        return pressed_breast(setup, inputs["standard_path"].end(setup), thresholds)
    if uses_standard(inputs):
        setup = replace(setup, standard=_known(inputs))
    try:
        return pressed_breast(setup, strategy.press(setup), thresholds)
    except NoStandard:
        inputs["standard_path"]  # raises why there is none
        raise


def _known(inputs: Inputs) -> LoadPath | None:
    """The standard's load path; None where it was not found."""
    try:
        found: LoadPath | None = inputs["standard_path"]
        return found
    except MammosimError:
        return None


TABLES = ("path", "faces", "amounts", "thickness")


def save_pressed(found: Pressed, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The shape with displacement, strains and stress, a row, tables, and where the plates are."""
    cells = {name: found.cells[name].to_numpy() for name in found.cells.columns.drop("tissue")}
    fields = {**found.fields.cells, **cells}
    write_mesh(found.mesh, files["shape"], point_data=found.fields.nodes, cell_data=fields)
    write_table(pd.DataFrame([{**job, **found.row}]), files["row"])
    write_json(dict(found.plates), files["plates"])
    for name in TABLES:
        table = getattr(found, name)
        write_table(table.assign(**job)[[*job, *table.columns]], files[name])


def load_pressed(files: Mapping[str, str]) -> Pressed:
    """What save_pressed wrote: shape, row and plates, without the tables beside them."""
    nothing = pd.DataFrame()
    row = read_table(files["row"]).iloc[0].to_dict()
    tables = dict.fromkeys((*TABLES, "cells"), nothing)
    return Pressed(read_mesh(files["shape"]), row=row, plates=read_json(files["plates"]), **tables)
