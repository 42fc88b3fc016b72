"""Every figure is drawn from small made-up data: axes named with units, finite data, nothing left over."""

import io
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from mammosim.core.labels import Label
from mammosim.core.volume import LabelMap
from mammosim.figures import (
    compression,
    deformation,
    hard_cases,
    literature,
    radiograph,
    status,
    surfaces,
    unloading,
    volunteers,
)
from mammosim.io.tabulated import tabulated
from mammosim.study.identification.published import beside, ratios

GRAVITY = {"prone": np.array([0, -1.0, 0]), "supine": np.array([0, 1.0, 0])}


def plots(figure: Figure) -> list[Axes]:
    """Axes with an axis to read: not pictures with a scale bar, not legends."""
    return [ax for ax in figure.axes if ax.axison and ax.get_label() != "<colorbar>"]


def require_readable(figure: Figure) -> None:
    assert isinstance(figure, Figure)
    for ax in plots(figure):
        labels = [ax.get_xlabel(), ax.get_ylabel()]
        assert any("(" in label for label in labels), f"no unit on {ax.get_title()!r}: {labels}"
        assert np.all(np.isfinite([*ax.get_xlim(), *ax.get_ylim()]))
    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=40)
    assert memory.tell() > 3000
    figure.draw_without_rendering()
    require_clear(figure)


def require_clear(figure: Figure) -> None:
    """Texts lie inside the figure and name no keys of sources, and legends lie beside the lines."""
    width, height = figure.bbox.size
    for text in texts_of(figure):
        box = text.get_window_extent()
        inside = box.x0 > -3 and box.y0 > -3 and box.x1 < width + 3 and box.y1 < height + 3
        assert inside, f"{text.get_text()!r} is cut off: {box}"
        assert "[@" not in text.get_text(), "a figure names its sources, not their keys"
    for ax in figure.axes:
        if (legend := ax.get_legend()) is not None:
            box = legend.get_window_extent()
            assert not any(box.contains(*point) for point in shown_points(ax)), ax.get_title(loc="left")


def texts_of(figure: Figure) -> Iterator[Text]:
    """Titles, labels, names of ticks within their axes, and words."""
    for ax in figure.axes:
        if ax.axison:
            yield from (ax.xaxis.label, ax.yaxis.label)
        yield from (t for t in ax.get_children() if isinstance(t, Text) and t.get_text())
    yield from figure.texts
    yield from (text for legend in figure.legends for text in legend.get_texts())


def shown_points(ax: Axes) -> Iterator[np.ndarray]:
    """Pixels of points along its lines."""
    for line in ax.lines:
        if line.get_transform() == ax.transData and len(line.get_xdata()) > 1:
            points = ax.transData.transform(
                np.column_stack([line.get_xdata(orig=False), line.get_ydata(orig=False)])
            )
            for a, b in pairwise(points):
                yield from np.linspace(a, b, 20)


def sweep_table() -> pd.DataFrame:
    rows = [
        {"volunteer": v, "youngs_modulus_kpa": E, "nipple_left_mm": 9 / E, "nipple_right_mm": 8 / E,
         "max_displacement_mm": 20 / E, "supine_left_mm": 30.0, "supine_right_mm": 28.0,
         "outcome": "converged"}
        for v in ("small", "large") for E in (0.5, 5.0)
    ]  # fmt: skip
    rows[0] |= {"nipple_left_mm": np.nan, "max_displacement_mm": np.nan, "outcome": "failed: unloading: -"}
    return pd.DataFrame(rows)


def hard_case_table() -> pd.DataFrame:
    return pd.DataFrame({
        "case": ["soft", "lost", "inverted", "wrong"], "family": ["soft", "soft", "bad input", "bad input"],
        "outcome": ["converged", "unstable: -", "rejected: -", "crashed: ValueError"],
        "ok": [True, True, True, False], "error": [0.002, 0.01, np.nan, np.nan],
        "within": [0.01, 0.05, np.nan, 0.01], "seconds": [3.0, 9.0, 0.1, 0.2],
    })  # fmt: skip


def shot() -> dict[str, Any]:
    v, u = np.indices((60, 80))
    thick = 60 * np.clip(1 - ((u - 40) / 35) ** 2 - (v / 50) ** 2, 0, None) ** 0.3
    return {"image": 1e4 * np.exp(-0.05 * thick), "pixel_mm": 1.0, "unobstructed": 1e4,
            "lesion": np.hypot(v - 20, u - 40) < 4}  # fmt: skip


def fitted_moduli() -> pd.DataFrame:
    return pd.DataFrame({"volunteer": "small", "side": ["left", "right", "left"],
                         "tissue": ["adipose", "adipose", "fascia"], "fitted_kpa": [0.5, 0.6, 0.0],
                         "low_kpa": [0.4, 0.5, 0.0], "high_kpa": [0.6, 0.8, 185.0],
                         "identifiable": [True, True, False]})  # fmt: skip


def morph_history() -> pd.DataFrame:
    return pd.DataFrame({"level": [0, 1, 2], "stiffness_kpa_per_mm": [0, 0.1, 1.0], "mean_mm": [5, 1.0, 0.3],
                         "p95_mm": [9, 2.0, 0.9], "energy_uj": [0, 2e4, 4e4]})  # fmt: skip


CASES: dict[str, Callable[[Any], Figure]] = {
    "positions": lambda t: volunteers.positions(
        dict.fromkeys(GRAVITY, t.image), dict.fromkeys(GRAVITY, t.fiducials), GRAVITY
    ),
    "morph": lambda t: deformation.morph(
        {"prone": t.mesh, "supine": t.flat, "morphed": t.flat, "mean": t.mesh},
        np.linspace(0, 3, len(t.flat.points)), morph_history(), x_mm=75.0, z_mm=0.0,
    ),
    "registration": lambda t: volunteers.registration(
        t.image, t.image, t.image,
        pd.DataFrame({"step": ["landmarks", "image"], "marker_residual_mm": [1.0, 0.8]}), at_mm=0.0,
    ),
    "registration without markers": lambda t: volunteers.registration(
        t.image, t.image, t.image,
        pd.DataFrame(
            {"step": ["surface", "image"], "marker_residual_mm": [np.nan] * 2, "error_95_mm": [2.0, 0.1]}
        ),
        at_mm=0.0,
    ),
    "segmentation": lambda t: volunteers.segmentation(
        t.image, t.labels, pd.DataFrame({"tissue": ["adipose"], "dice": [0.9]}),
        point=np.array([75.0, -60, 0]),
    ),
    "segmentation without truth": lambda t: volunteers.segmentation(
        t.image, t.labels, point=np.array([75.0, -60, 0])
    ),
    "mesh": lambda t: surfaces.mesh_with_tissues(
        t.mesh, cut_x_mm=75.0, nipples=t.fiducials.of_kind("nipple")
    ),
    "sweep": lambda t: deformation.sweep(sweep_table()),
    "upright": lambda t: deformation.upright(
        {"none": t.mesh, "10 kPa": t.flat},
        pd.DataFrame({"skin_kpa": [0.0, 10.0], "max_displacement_mm": [20.0, 15.0]}), x_mm=75.0,
    ),
    "stress free": lambda t: deformation.stress_free(
        {"measured": t.mesh, "fixed point": t.flat}, x_mm=75.0, z_mm=0.0
    ),
    "convergence": lambda t: unloading.convergence(
        pd.DataFrame({"volunteer": "small", "method": ["reverse_gravity"] + ["fixed_point"] * 3,
                      "iteration": [0, 0, 1, 2], "max_mm": [np.nan, 9.0, 2.0, 0.4]}), tolerance_mm=0.1,
    ),
    "unloading": lambda t: unloading.unloading(
        pd.DataFrame({"volunteer": "small", "youngs_modulus_kpa": [0.2, 1.0] * 2,
                      "method": ["fixed_point"] * 2 + ["inverse"] * 2,
                      "outcome": ["failed: -"] + ["converged"] * 3,
                      "error_mean_mm": [np.nan, 1e-3, 1e-4, 1e-5], "round_max_mm": [np.nan, 0.05, 1e-3, 1e-4],
                      "forward_solves": [np.nan, 6.0, 3.0, 1.5]})
    ),
    "compressed breast": lambda t: compression.compressed_breast(
        t.mesh, t.flat, (compression.Plate(np.array([75.0, -90, 40]), np.eye(3), np.array([80.0, 50, 4])),),
        strain=np.linspace(0, 0.4, len(t.mesh.cells)),
        pressure=np.linspace(0, 5, len(t.mesh.boundaries["skin"])), cut_x_mm=75.0,
    ),
    "phantom": lambda t: radiograph.phantom_slices(t.labels),
    "mammogram": lambda t: radiograph.mammogram(**shot(), row={"mas": 80.0, "cnr": 3.0, "cnr_se": 0.1}),
    "mammogram right": lambda t: radiograph.mammogram(**shot(), side="right"),
    "literature": lambda t: literature.moduli(fitted_moduli(), {"sweep": (0.5, 20.0), "skin": (10.0, 10.0)}),
    "gravity and compression": lambda t: literature.gravity_and_compression(
        fitted_moduli(), ratios(beside(tabulated("published_biomechanics"), fitted_moduli()))
    ),
    "cost": lambda t: status.time_and_memory(
        pd.DataFrame({"rule": ["sweep", "sweep", "segment"], "s": [9.0, 8, 30], "max_rss": [900.0, 800, 700]})
    ),
    "hard cases": lambda t: hard_cases.hard_cases(hard_case_table()),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_every_figure_is_drawn_with_units_on_its_axes(name, torso):
    require_readable(CASES[name](torso))


def test_drawing_leaves_the_settings_of_the_session_alone(torso):
    before = dict(mpl.rcParams)
    deformation.sweep(sweep_table())
    assert dict(mpl.rcParams) == before


def test_a_row_without_solution_is_a_cross_and_not_a_point(torso):
    figure = deformation.sweep(sweep_table())
    crosses = [line for line in figure.axes[0].lines if "no equilibrium" in str(line.get_label())]
    np.testing.assert_array_equal(crosses[0].get_xdata(), [0.5])


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_mammogram_hangs_with_the_chest_wall_at_the_side_of_the_breast_and_lateral_above(side):
    given = shot()
    given["image"] = np.where(given["lesion"], 100.0, given["image"])
    ax = radiograph.mammogram(**given, side=side).axes[0]
    assert ax.get_xlim()[0] < ax.get_xlim()[1]
    shown = ax.images[0].get_array()
    # Its rows run from the chest wall, its columns to the patient's right: medial of the left breast.
    from_wall = ax.patches[0].center[0] if side == "left" else shown.shape[1] - ax.patches[0].center[0]
    assert from_wall == pytest.approx(20.5)  # mm
    dark = np.asarray(shown) < 0.01
    assert dark[:, 0 if side == "right" else -1].all(), "air beyond the nipple"
    words = {text.get_text(): text.get_position() for text in ax.texts}
    assert words[f"{side[0].upper()} CC\nlateral"][1] < words["medial"][1], "mm downward"
    assert (words["chest wall"][0] < 0.5) == (side == "left")
    left, right, bottom, _ = ax.images[0].get_extent()
    row, column = np.argwhere(shown == shown.max()).mean(axis=0) + 0.5
    drawn = left + (right - left) * column / shown.shape[1], bottom * row / shown.shape[0]
    assert ax.patches[0].center == pytest.approx(drawn, abs=0.6)  # half a pixel


def test_a_skin_has_the_same_colour_as_an_outline_and_as_a_bar(torso):
    shapes = {"measured, prone": torso.mesh, "without skin": torso.flat, "skin 10 kPa": torso.flat}
    rows = pd.DataFrame({"skin_kpa": [0.0, 10.0], "max_displacement_mm": [20.0, 15.0]})
    outlines, bars = deformation.upright(shapes, rows, x_mm=75.0).axes
    lines = [to_hex(line.get_colors()[0]) for line in outlines.collections]
    assert [to_hex(bar.get_facecolor()) for bar in bars.patches] == lines[1:]


def test_labels_of_every_tissue_have_a_colour_in_the_phantom(torso):
    values = np.where(torso.labels.values == Label.GLANDULAR, Label.LESION, torso.labels.values)
    require_readable(radiograph.phantom_slices(LabelMap(torso.labels.grid, values.astype(np.uint8))))
