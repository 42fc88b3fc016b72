"""Strategies of compression drawn side by side: on common scales, and one that failed is named."""

import numpy as np
import pandas as pd
import pytest
from conftest import title
from matplotlib.image import AxesImage

from mammosim.core.errors import MissingResult
from mammosim.figures.pressure import Pressures, pressure
from mammosim.figures.strategies import Marks, Strained, amounts, curves, discomfort, thickness_maps

MARKS = Marks((50.0, 180.0), "practice", 10.0, "a standard")
STRATEGIES = ("standard", "reduced", "tilted")


def way(volunteer: str, strategy: str, moduli: str) -> pd.DataFrame:
    thickness = np.linspace(90, 60 if strategy == "reduced" else 45, 8)
    force = (90 - thickness) ** 1.5 / 30 * (5 if moduli == "compression" else 1)
    area = 40 * (90 - thickness)
    with np.errstate(invalid="ignore"):
        pressure = np.nan_to_num(1e3 * force / area)
    return pd.DataFrame(
        {"thickness_mm": thickness, "force_n": force, "contact_area_mm2": area,
         "mean_pressure_kpa": pressure, "peak_pressure_kpa": 2 * pressure}
    ).assign(volunteer=volunteer, side="left", strategy=strategy, moduli=moduli)  # fmt: skip


def paths() -> pd.DataFrame:
    return pd.concat(
        [way(v, s, m) for v in ("small", "large") for s in STRATEGIES for m in ("gravity", "compression")]
    )


def place() -> pd.DataFrame:
    outward, across = (grid.ravel() for grid in np.meshgrid(np.arange(1, 61, 2), np.arange(-39, 41, 2)))
    inside = np.hypot(outward, across) < 50
    thickness = 50 - 0.1 * outward - 40 * (np.hypot(outward, across) / 50) ** 12
    return pd.DataFrame({"outward_mm": outward, "across_mm": across, "thickness_mm": thickness})[inside]


def test_a_row_of_curves_for_each_set_of_moduli_shares_its_scales():
    figure = curves(paths(), MARKS)
    assert len(figure.axes) == 2 * 4
    assert figure.axes[0].get_ylim() == figure.axes[4].get_ylim()
    assert all("(" in ax.get_ylabel() for ax in figure.axes)
    assert figure.axes[0].get_ylim()[1] >= 180.0, "what is usual in practice is in the picture"


def test_without_marks_of_its_own_the_force_of_practice_is_shown():
    band = curves(paths()).axes[0].patches[0]
    # de Groot 2015: 50 to 180 N.
    assert (band.get_y(), band.get_y() + band.get_height()) == (50.0, 180.0)


def test_nothing_pressed_is_a_missing_result():
    for draw in (curves, amounts):
        with pytest.raises(MissingResult, match="no strategy pressed any breast"):
            draw(pd.DataFrame())


def test_one_thickness_scale_serves_all_strategies_and_one_that_failed_is_named():
    maps = {"standard": place(), "tilted": place().assign(thickness_mm=30.0), "flexible": place().iloc[:0]}
    figure = thickness_maps(maps)
    scales = {panel.collections[0].get_clim() for panel in figure.axes[:2]}
    assert len(scales) == 1
    titles = [title(ax) for ax in figure.axes[:3]]
    assert ["failed" in title for title in titles] == [False, False, True]


def test_strain_energy_and_pressure_stand_in_columns_with_a_scale_each(torso):
    n_cell, n_face = len(torso.mesh.cells), len(torso.mesh.boundaries["skin"])
    strained = {
        name: Strained(mesh, np.linspace(0, 1, n_cell), np.linspace(0, 2, n_cell), np.linspace(-1, 5, n_face))
        for name, mesh in (("standard", torso.mesh), ("reduced", torso.flat))
    }
    figure = discomfort(strained, centre=np.array([75.0, -60.0, 0.0]))
    pictures = [ax for ax in figure.axes if any(isinstance(child, AxesImage) for child in ax.images)]
    assert len(pictures) == 3 * 2
    bars = [ax.get_xlabel() for ax in figure.axes if ax.get_label() == "<colorbar>"]
    assert [label.split(" (")[1] for label in bars] == ["-)", "kPa)", "kPa)"]


def test_the_bars_are_as_high_as_the_amounts():
    rows = [
        {"volunteer": "small", "side": "left", "strategy": s, "moduli": m, "measure": measure,
         "threshold": mark, "tissue": tissue, "amount": 100.0 / (1 + mark), "unit": unit}
        for s in STRATEGIES for m in ("gravity", "compression")
        for measure, tissue, unit in (("logarithmic", "all", "cm3"), ("pressure_kpa", "skin", "cm2"))
        for mark in (0.25, 1.0)
    ]  # fmt: skip
    figure = amounts(pd.DataFrame(rows))
    heights = {round(bar.get_height(), 6) for ax in figure.axes for bar in ax.patches}
    assert heights == {80.0, 50.0}


def test_pressures_of_both_plates_stand_beside_their_differences_from_the_standard(torso):
    n = len(torso.mesh.boundaries["skin"])
    flat = Pressures(torso.flat, np.linspace(-1, 5, n).clip(0), np.linspace(2, -1, n).clip(0))
    soft = Pressures(torso.flat, flat.paddle_kpa / 2, flat.support_kpa * 3)
    figure = pressure({"standard": flat, "soft": soft}, centre=np.array([75.0, -60.0, 0.0]))
    pictures = [ax for ax in figure.axes if ax.images]
    words = ["soft, paddle", "soft, support", "less standard", "less standard"]
    assert [title(ax) for ax in pictures[4:]] == words
    bars = {ax.get_xlabel(): ax.get_xlim() for ax in figure.axes if ax.get_label() == "<colorbar>"}
    assert bars == {"pressure (kPa)": (0.0, 6.0), "difference (kPa)": (-4.0, 4.0)}
    alone = pressure({"soft": soft}, centre=np.array([75.0, -60.0, 0.0]))
    assert len([ax for ax in alone.axes if ax.images]) == 2
