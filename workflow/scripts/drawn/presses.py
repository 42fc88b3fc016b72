"""Breasts between the plates: shape, strain, pressure, thickness, of one strategy and of all."""

import numpy as np
from matplotlib.figure import Figure

from mammosim.figures import compression as figures
from mammosim.figures import pressure as figures_of_pressure
from mammosim.figures import strategies
from mammosim.io.meshes import read_cell_data, read_mesh
from mammosim.io.tables import read_if_there, read_json, read_table


def compression(files: dict, told: dict, job: dict) -> Figure:
    """Cut through the middle of the plates."""
    facts = read_json(files["plates"])
    half = np.array([facts["high_x_mm"] - facts["low_x_mm"], facts["depth_mm"], facts["height_mm"]]) / 2
    x = (facts["low_x_mm"] + facts["high_x_mm"]) / 2
    y = facts["chest_y_mm"] - half[1]
    heights = (facts["paddle_z_mm"] + half[2], facts["support_z_mm"] - half[2])
    return figures.compressed_breast(
        read_mesh(files["stress_free"]),
        read_mesh(files["shape"]),
        tuple(figures.Plate(np.array([x, y, z]), np.eye(3), half) for z in heights),
        strain=read_cell_data(files["shape"], "green_lagrange"),
        pressure=read_table(files["faces"]).paddle_kpa.to_numpy(),
        cut_x_mm=x,
    )


def thickness(files: dict, told: dict, job: dict) -> Figure:
    """told: the strategies in the order of the maps."""
    found = {name: read_if_there(path) for name, path in zip(told["strategies"], files["maps"])}
    if all(rows.empty for rows in found.values()):
        read_json(files["plates"])  # says why the standard is missing, and the others with it
    return strategies.thickness_maps(found)


def discomfort(files: dict, told: dict, job: dict) -> Figure:
    """Of the strategies that found an equilibrium; told: the strategies in the order of the files."""
    pressed = {}
    for name, shape, faces in zip(told["strategies"], files["shapes"], files["faces"]):
        if len(table := read_if_there(faces)):
            measures = {each: read_cell_data(shape, each) for each in ("logarithmic", "energy_kpa")}
            pressure = table.pressure_kpa.to_numpy()
            pressed[name] = strategies.Strained(read_mesh(shape), pressure_kpa=pressure, **measures)
    return strategies.discomfort(pressed, centre=_middle(files))


def pressure(files: dict, told: dict, job: dict) -> Figure:
    """Of the same strategies."""
    pressed = {}
    for name, shape, faces in zip(told["strategies"], files["shapes"], files["faces"]):
        if len(table := read_if_there(faces)):
            each = (table[f"{plate}_kpa"].to_numpy() for plate in ("paddle", "support"))
            pressed[name] = figures_of_pressure.Pressures(read_mesh(shape), *each)
    return figures_of_pressure.pressure(pressed, centre=_middle(files))


def _middle(files: dict) -> np.ndarray:
    """Of the standard's plates, at the chest edge. Raises MissingResult where they are missing."""
    facts = read_json(files["plates"])
    x = (facts["low_x_mm"] + facts["high_x_mm"]) / 2
    z = (facts["support_z_mm"] + facts["paddle_z_mm"]) / 2
    return np.array([x, facts["chest_y_mm"], z])
