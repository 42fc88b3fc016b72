"""The breast between the plates: by the standard strategy, and by the strategy of the load.

Effects: weight and friction.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.breast import Breast
from mammosim.chain.conditions import continues_standard
from mammosim.chain.graph import Inputs
from mammosim.chain.plates import craniocaudal_plates
from mammosim.chain.points import MaterialPoints
from mammosim.chain.pressed import Pressed, pressed_breast
from mammosim.chain.strategies import LoadPath, NoStandard, PressSetup, Strategy, ThicknessShare
from mammosim.core.errors import MammosimError
from mammosim.core.positions import gravity_direction
from mammosim.io.meshes import read_mesh, read_point_data, write_mesh
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.mechanics.paddles import Friction, Rigid
from mammosim.mechanics.stage import PressSettings

# ASSUME: a woman stands while her breast is pressed.
STANDING = "upright"


def press_setup(inputs: Inputs) -> PressSetup:
    """The stress-free breast before the plates."""
    rest, body, measured = inputs["stress_free"].mesh, inputs["pressed_body"], inputs["mesh"]
    breast: Breast = inputs["breast"]
    nipple = MaterialPoints.on(measured, breast.to_reference(breast.nipple[None])).carry(rest.points)[0]
    given: Mapping[str, Any] = {name: inputs.setting(f"compression.{name}") for name in GIVEN}
    plates = craniocaudal_plates(rest, nipple, plate_mm=given["plate_mm"], chest_gap_mm=given["chest_gap_mm"])
    effects = body.effects(rest)
    if inputs.has("weight"):
        effects += (body.weight(rest, gravity_direction(STANDING)),)
    if inputs.has("friction"):
        plates = replace(plates, friction=Friction(**inputs.setting("effects.friction")))
    return PressSetup(
        rest,
        effects,
        plates,
        moduli=inputs.setting("load.moduli"),
        thickness_mm=inputs.setting("load.thickness_mm"),
        smallest_mm=given["smallest_mm"],
        solved=PressSettings(steps=given["steps"], penetration_mm=given["penetration_mm"]),
    )


GIVEN = ("plate_mm", "chest_gap_mm", "smallest_mm", "steps", "penetration_mm")


def standard_path(inputs: Inputs) -> LoadPath:
    """The load path of the standard strategy, which others are measured by."""
    setup: PressSetup = inputs["press_setup"]
    return LoadPath.of(setup.mesh, ThicknessShare(1.0).press(setup, Rigid()))


def save_standard_path(found: LoadPath, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """The shapes of all steps as point data of one mesh of their last, and their table."""
    write_mesh(found.mesh, files["shapes"], point_data=found.point_data())
    write_table(found.path, files["path"])


def load_standard_path(files: Mapping[str, str]) -> LoadPath:
    """What save_standard_path wrote."""
    mesh, path = read_mesh(files["shapes"]), read_table(files["path"])
    shapes = [read_point_data(files["shapes"], name) for name in LoadPath.names(len(path))]
    return LoadPath(path, np.array(shapes), mesh)


def pressed(inputs: Inputs) -> Pressed:
    """The breast between the plates, where the strategy of the load ends.

    It goes on from the load path of the standard strategy. Where that found no equilibrium, a strategy that
    does not need it is pressed from first contact.
    """
    strategy, setup = Strategy.of(inputs.setting("load.strategy")), inputs["press_setup"]
    if continues_standard(inputs):
        # The standard itself is where its load path ends; without one it has no answer.
        itself = strategy == Strategy(Rigid(), ThicknessShare(1.0))
        setup = replace(setup, standard=inputs["standard_path"] if itself else _known(inputs))
    try:
        return pressed_breast(setup, strategy.press(setup), inputs.setting("compression.thresholds"))
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
    """The shape with its strains, a row, tables, and where the plates are."""
    cells = {name: found.cells[name].to_numpy() for name in found.cells.columns.drop("tissue")}
    write_mesh(found.mesh, files["shape"], cell_data=cells)
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
