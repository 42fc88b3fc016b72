"""Predicted over measured, and intervals of what follows: what is drawn is what the tables say."""

import numpy as np
import pandas as pd
from conftest import title

from mammosim.figures.identification import propagation
from mammosim.figures.validation import SkinMap, prediction, wrong_model


def test_faces_show_the_mean_of_the_nodes_that_have_a_distance(torso):
    nodes = torso.mesh.boundary_nodes("skin")
    distance = np.where(torso.mesh.points[nodes, 0] > 0, 3.0, np.nan)
    on_faces = SkinMap(torso.mesh, distance).on_faces()
    right = torso.mesh.points[torso.mesh.boundaries["skin"]][..., 0].max(axis=1) <= 0
    np.testing.assert_array_equal(np.isnan(on_faces), right)
    np.testing.assert_allclose(on_faces[~right], 3.0)


def test_every_position_has_a_curve_that_ends_at_all_of_its_skin(torso):
    distances = {"supine, fitted": np.array([2.0, 1.0, 3.0, 4.0]), "tilted, held out": np.array([5.0, 1.0])}
    away = np.ones(len(torso.mesh.boundary_nodes("skin")))
    figure = prediction(
        {"measured": torso.mesh, "predicted": torso.flat},
        SkinMap(torso.mesh, away),
        distances,
        x_mm=75.0,
        z_mm=0.0,
    )
    curves = next(ax for ax in figure.axes if title(ax) == "all positions").lines
    assert [line.get_label() for line in curves] == list(distances)
    assert [float(np.max(line.get_xdata())) for line in curves] == [4.0, 5.0]
    assert all(np.max(line.get_ydata()) == 100 for line in curves)


def test_a_prediction_that_failed_leaves_the_measured_position(torso):
    away = np.full(len(torso.mesh.boundary_nodes("skin")), np.nan)
    figure = prediction({"measured": torso.mesh}, SkinMap(torso.mesh, away), {}, x_mm=75.0, z_mm=0.0)
    assert len(figure.axes[0].collections) == 1


def test_intervals_of_the_nipples_are_drawn_about_the_fit():
    rows = [
        ("small", "left", quantity, 50.0, 48.0, 51.0, 50.5)
        for quantity in ("nipple_x_mm", "nipple_y_mm", "nipple_z_mm")
    ]
    rows += [
        ("small", "left", "force_n", 2.0, 1.5, 2.5, np.nan),
        ("small", "left", "agd_mgy", 1.0, 1.0, 1.1, np.nan),
    ]
    columns = ["volunteer", "side", "quantity", "fit", "low", "high", "measured"]
    nipple, force, dose = propagation(pd.DataFrame(rows, columns=columns)).axes
    fit, measured = nipple.lines
    np.testing.assert_allclose(fit.get_xdata(), 0.0)
    np.testing.assert_allclose(measured.get_xdata(), 0.5)
    assert [len(ax.collections[0].get_segments()) for ax in (nipple, force, dose)] == [3, 1, 1]
    assert [ax.get_xlim()[0] for ax in (force, dose)] == [0.0, 0.0]


def test_the_right_and_the_wrong_model_stand_side_by_side_in_every_position():
    rows = [
        (position, position == "supine", quantity, 1.0, 2.0)
        for position in ("supine", "supine_tilted")
        for quantity in ("nipple_left", "nipple_right", "marker_mean", "skin_mean", "skin_p95")
    ]
    figure = wrong_model(
        pd.DataFrame(rows, columns=["position", "fitted", "quantity", "right_mm", "wrong_mm"])
    )
    assert [title(ax) for ax in figure.axes] == ["supine, fitted", "supine tilted, held out"]
    assert all(sorted(bar.get_width() for bar in ax.patches) == [1.0] * 5 + [2.0] * 5 for ax in figure.axes)
