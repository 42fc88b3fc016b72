"""Fits: how they came to their moduli, their shapes, and predicted over measured positions."""

import numpy as np
from matplotlib.figure import Figure

from mammosim.core.errors import MissingResult
from mammosim.figures import deformation, validation
from mammosim.figures import identification as moduli
from mammosim.figures.surfaces import left_breast
from mammosim.io.meshes import read_mesh
from mammosim.io.tables import read_table
from mammosim.io.written import read_fiducials
from mammosim.meshing.distance import distance_opposite, distance_to_rim
from mammosim.study.identification.validation import CUT_MM, skin_distances

SHAPES = {
    "prone": "measured prone",
    "supine": "measured supine",
    "stress_free": "stress-free",
    "predicted": "supine from stress-free",
}


def identification(files: dict, told: dict, job: dict) -> Figure:
    """told: the prior."""
    grid, history, table = (
        read_table(files[name], may_be_empty=True) for name in ("grid", "history", "moduli")
    )
    return moduli.identification(grid, history, table, told["prior"])


def fitted_shapes(files: dict, told: dict, job: dict) -> Figure:
    """Prone and supine as measured, the stress-free shape of the fit, and supine as the fit predicts it."""
    shapes = {name: read_mesh(files[key]) for key, name in SHAPES.items()}
    known = {name: mesh for name, mesh in shapes.items() if np.isfinite(mesh.points).all()}
    x, _, z = read_fiducials(files["fiducials"]).point("nipple_left")
    return deformation.stress_free(known, x_mm=x, z_mm=z)


def prediction(files: dict, told: dict, job: dict) -> Figure:
    """One position, and distances of the skin in all; told: which were fitted, in the order of the files."""
    pairs, fitted, position = {}, told["fitted"], job["p"]
    for name, shape, measured in zip(fitted, files["shapes"], files["measured"]):
        try:
            pairs[name] = read_mesh(shape), read_mesh(measured)
        except MissingResult:
            if name == position:
                raise
    known = {name: pair for name, pair in pairs.items() if np.isfinite(pair[0].points).all()}
    distances = {
        f"{name.replace('_', ' ')}, {'fitted' if fitted[name] else 'held out'}": skin_distances(*pair)
        for name, pair in known.items()
    }
    measured = pairs[position][1]
    shapes, away = {"measured": measured}, np.full(len(measured.boundary_nodes("skin")), np.nan)
    if position in known:
        shapes["predicted"] = known[position][0]
        near_cut = distance_to_rim(measured) < CUT_MM
        away = np.where(near_cut, np.nan, distance_opposite(measured, shapes["predicted"]))
    x, _, z = left_breast(read_fiducials(files["fiducials"]), measured)
    return validation.prediction(shapes, validation.SkinMap(measured, away), distances, x_mm=x, z_mm=z)
